//! The tracer against slow and obvious twins.
