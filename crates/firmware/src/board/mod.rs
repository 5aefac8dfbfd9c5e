//! What differs between the boards, and the stack.

#[cfg(target_arch = "arm")]
mod cortex_m;
#[cfg(target_arch = "riscv32")]
mod riscv_virt;

#[cfg(target_arch = "arm")]
pub use cortex_m::Counter;
#[cfg(target_arch = "riscv32")]
pub use riscv_virt::Counter;

/// What the stack is filled with before the work.
const PAINT: u32 = 0xA5A5_A5A5;
/// Bytes below the painter's own frame that are left alone.
const MARGIN: usize = 256;

#[expect(unsafe_code, reason = "the linker script's names of the stack's ends")]
mod ends {
    unsafe extern "C" {
        /// The lowest address of the stack.
        pub(super) static mut _stack_limit: u32;
        /// One past its highest.
        pub(super) static mut _stack_start: u32;
    }
}

/// Fills the unused part of the stack, so that [`stack_used`] can tell how deep it went.
#[inline(never)]
pub fn paint_stack() {
    let here = 0u32;
    let top = (&raw const here).addr() - MARGIN;
    let mut at = &raw mut ends::_stack_limit;
    while at.addr() < top {
        // SAFETY: between the stack's limit and the margin below this frame nothing lives.
        #[expect(unsafe_code, reason = "the stack is no Rust object")]
        unsafe {
            at.write_volatile(PAINT);
            at = at.add(1);
        }
    }
}

/// The most bytes of stack in use at once since [`paint_stack`].
#[must_use]
pub fn stack_used() -> usize {
    let end = (&raw const ends::_stack_start).addr();
    let mut at = &raw const ends::_stack_limit;
    while at.addr() < end {
        // SAFETY: reads memory of the stack's region, which has any contents.
        #[expect(unsafe_code, reason = "the stack is no Rust object")]
        unsafe {
            if at.read_volatile() != PAINT {
                break;
            }
            at = at.add(1);
        }
    }
    end - at.addr()
}
