//! A configuration as text: one of [`NAMED`] and what differs from it, as in
//! `adaptive,fit=mean,hidden=off`. Jobs for the firmware carry it.

use super::{Config, Extents, Fit, Lifetime, Light, Mode, NAMED, TimeKernel};
use core::fmt;

impl Config {
    /// Reads what [`fmt::Display`] writes: a name, then `KNOB=VALUE` after commas, any number in
    /// any order. `fit`: mean, plane; `hidden`, `fill`, `rest`, `reproject`: on, off; `light`:
    /// linear, encoded; `kernel`: rational, gaussian, exponential; `cutoff`: a weight with 15
    /// fractional bits, below one; `width`: density, gradient, pixel, or log2 of σ in pixels with 8
    /// fractional bits; `lifetime`: tiles, gradient, or log2 of seconds with 8 fractional bits.
    /// `None` where a word is not understood.
    #[must_use]
    pub fn parse(text: &[u8]) -> Option<Self> {
        let mut words = text.split(|byte| *byte == b',');
        let name = words.next()?;
        let named = NAMED.iter().find(|(known, _)| known.as_bytes() == name);
        let mut config = named?.1;
        for word in words {
            let mut sides = word.splitn(2, |byte| *byte == b'=');
            let (knob, value) = (sides.next()?, sides.next()?);
            match knob {
                b"fit" => {
                    config.fit = match value {
                        b"mean" => Fit::Constant,
                        b"plane" => Fit::Linear,
                        _ => return None,
                    }
                }
                b"hidden" => config.hidden = switch(value)?,
                b"fill" => config.fill = switch(value)?,
                b"rest" => config.rest = switch(value)?,
                b"reproject" => config.reproject = switch(value)?,
                b"light" => {
                    config.light = match value {
                        b"linear" => Light::Linear,
                        b"encoded" => Light::Encoded,
                        _ => return None,
                    }
                }
                b"kernel" => {
                    config.kernel = match value {
                        b"rational" => TimeKernel::Rational,
                        b"gaussian" => TimeKernel::Gaussian,
                        b"exponential" => TimeKernel::Exponential,
                        _ => return None,
                    }
                }
                b"cutoff" => config.cutoff = integer(value)?.try_into().ok()?,
                b"width" => {
                    config.extents = match value {
                        b"density" => Extents::Density,
                        b"gradient" => Extents::Gradient,
                        b"pixel" => Extents::Pixel,
                        log => Extents::Constant(integer(log)?),
                    }
                }
                b"lifetime" => {
                    config.lifetime = match value {
                        b"tiles" => Lifetime::Tiles,
                        b"gradient" => Lifetime::Gradient,
                        log => Lifetime::Constant(integer(log)?),
                    }
                }
                _ => return None,
            }
        }
        Some(config)
    }
}

fn switch(value: &[u8]) -> Option<bool> {
    match value {
        b"on" => Some(true),
        b"off" => Some(false),
        _ => None,
    }
}

fn integer(digits: &[u8]) -> Option<i16> {
    let (digits, sign) = match digits.split_first() {
        Some((b'-', rest)) => (rest, -1),
        _ => (digits, 1),
    };
    if digits.is_empty() {
        return None;
    }
    digits.iter().try_fold(0i16, |value, byte| {
        let digit = byte.checked_sub(b'0').filter(|digit| *digit < 10)?;
        let digit = sign * i16::from(digit);
        value.checked_mul(10)?.checked_add(digit)
    })
}

impl fmt::Display for Config {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (name, base) = match self.mode {
            Mode::SpaceTime => ("adaptive", Self::ADAPTIVE),
            Mode::Newest => ("frameless", Self::NEWEST),
        };
        f.write_str(name)?;
        if self.fit != base.fit {
            let fit = match self.fit {
                Fit::Constant => "mean",
                Fit::Linear => "plane",
            };
            write!(f, ",fit={fit}")?;
        }
        for (knob, own, base) in [
            ("hidden", self.hidden, base.hidden),
            ("fill", self.fill, base.fill),
            ("rest", self.rest, base.rest),
            ("reproject", self.reproject, base.reproject),
        ] {
            if own != base {
                write!(f, ",{knob}={}", if own { "on" } else { "off" })?;
            }
        }
        if self.light != base.light {
            let light = match self.light {
                Light::Linear => "linear",
                Light::Encoded => "encoded",
            };
            write!(f, ",light={light}")?;
        }
        if self.kernel != base.kernel {
            let kernel = match self.kernel {
                TimeKernel::Rational => "rational",
                TimeKernel::Gaussian => "gaussian",
                TimeKernel::Exponential => "exponential",
            };
            write!(f, ",kernel={kernel}")?;
        }
        if self.cutoff != base.cutoff {
            write!(f, ",cutoff={}", self.cutoff)?;
        }
        if self.extents != base.extents {
            match self.extents {
                Extents::Density => f.write_str(",width=density")?,
                Extents::Gradient => f.write_str(",width=gradient")?,
                Extents::Pixel => f.write_str(",width=pixel")?,
                Extents::Constant(log) => write!(f, ",width={log}")?,
            }
        }
        if self.lifetime != base.lifetime {
            match self.lifetime {
                Lifetime::Tiles => f.write_str(",lifetime=tiles")?,
                Lifetime::Gradient => f.write_str(",lifetime=gradient")?,
                Lifetime::Constant(log) => write!(f, ",lifetime={log}")?,
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::format;
    use std::vec::Vec;

    /// Every knob at every value, one after the other and on top of each other.
    fn all() -> Vec<Config> {
        let mut all: Vec<Config> = NAMED.iter().map(|named| named.1).collect();
        let mut config = Config::ADAPTIVE;
        let knobs: [fn(&mut Config); 17] = [
            |c| c.fit = Fit::Constant,
            |c| c.hidden = false,
            |c| c.fill = false,
            |c| c.rest = false,
            |c| c.reproject = false,
            |c| c.light = Light::Encoded,
            |c| c.kernel = TimeKernel::Gaussian,
            |c| c.kernel = TimeKernel::Exponential,
            |c| c.cutoff = 0,
            |c| c.cutoff = 32_767,
            |c| c.extents = Extents::Gradient,
            |c| c.extents = Extents::Pixel,
            |c| c.extents = Extents::Constant(i16::MIN),
            |c| c.extents = Extents::Constant(i16::MAX),
            |c| c.lifetime = Lifetime::Gradient,
            |c| c.lifetime = Lifetime::Constant(-82),
            |c| c.lifetime = Lifetime::Constant(0),
        ];
        for knob in knobs {
            let mut alone = Config::ADAPTIVE;
            knob(&mut alone);
            knob(&mut config);
            all.extend([alone, config]);
        }
        all
    }

    #[test]
    fn what_is_written_is_read() {
        for config in all() {
            let text = format!("{config}");
            assert_eq!(Config::parse(text.as_bytes()), Some(config), "{text}");
        }
        for (name, config) in NAMED {
            assert_eq!(Config::parse(name.as_bytes()), Some(config));
        }
        assert_eq!(format!("{}", Config::ADAPTIVE), "adaptive");
    }

    #[test]
    fn what_is_not_understood_is_refused() {
        for bad in [
            "",
            "adaptiv",
            "adaptive,",
            "adaptive,fit",
            "adaptive,fit=",
            "adaptive,hidden=yes",
            "adaptive,width=40000",
            "adaptive,width=-",
            "adaptive,cutoff=-1",
            "adaptive,cutoff=32768",
            "adaptive,width=1.5",
            "adaptive,fit=mean,fit",
            "adaptive fit=mean",
        ] {
            assert_eq!(Config::parse(bad.as_bytes()), None, "{bad}");
        }
    }
}
