//! A display driver (`mipidsi`, an ST7789 with 16 bits a pixel) on an SPI bus that writes down what
//! goes over it.

use crate::Failure;
use crate::files::{BUS, Output};
use core::cell::Cell;
use core::convert::Infallible;
use embedded_graphics_core::draw_target::DrawTarget;
use embedded_graphics_core::pixelcolor::{Rgb565, RgbColor};
use embedded_hal::delay::DelayNs;
use embedded_hal::digital::{self, OutputPin};
use embedded_hal::spi::{self, Operation, SpiDevice};
use mipidsi::interface::SpiInterface;
use mipidsi::models::ST7789;
use mipidsi::{Builder, NoResetPin};

/// The wires of the bus.
pub struct Bus {
    file: Output,
    /// The data/command wire: high for data.
    data: Cell<bool>,
}

impl Bus {
    /// A bus that writes to [`BUS`].
    ///
    /// # Errors
    /// [`Failure::File`].
    pub fn new() -> Result<Self, Failure> {
        Ok(Self {
            file: Output::create(BUS)?,
            data: Cell::new(false),
        })
    }

    /// Marks the end of a refresh.
    ///
    /// # Errors
    /// [`Failure::File`].
    pub fn end_refresh(&self) -> Result<(), Failure> {
        self.record(2, &[])
    }

    fn record(&self, kind: u8, bytes: &[u8]) -> Result<(), Failure> {
        let len = u16::try_from(bytes.len()).map_err(|_| Failure::Driver)?;
        let [low, high] = len.to_le_bytes();
        self.file.write(&[kind, low, high])?;
        self.file.write(bytes)
    }
}

/// The bus as a device sees it.
pub struct Spi<'a>(&'a Bus);

impl spi::ErrorType for Spi<'_> {
    type Error = spi::ErrorKind;
}

impl SpiDevice for Spi<'_> {
    fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), spi::ErrorKind> {
        for operation in operations {
            match operation {
                Operation::Write(bytes) => {
                    let kind = u8::from(self.0.data.get());
                    let sent = self.0.record(kind, bytes);
                    sent.map_err(|_| spi::ErrorKind::Other)?;
                }
                Operation::DelayNs(_) => {}
                // The panel has no wire back.
                _ => return Err(spi::ErrorKind::Other),
            }
        }
        Ok(())
    }
}

/// The data/command pin.
pub struct DataPin<'a>(&'a Bus);

impl digital::ErrorType for DataPin<'_> {
    type Error = Infallible;
}

impl OutputPin for DataPin<'_> {
    fn set_low(&mut self) -> Result<(), Infallible> {
        self.0.data.set(false);
        Ok(())
    }

    fn set_high(&mut self) -> Result<(), Infallible> {
        self.0.data.set(true);
        Ok(())
    }
}

/// Nothing on this bus takes time.
struct NoDelay;

impl DelayNs for NoDelay {
    fn delay_ns(&mut self, _: u32) {}
}

/// The driver on its bus.
pub type Driver<'a> = mipidsi::Display<SpiInterface<'a, Spi<'a>, DataPin<'a>>, ST7789, NoResetPin>;

/// Wakes a black panel of this size.
///
/// # Errors
/// [`Failure::Driver`], also for a size beyond the controller's.
pub fn driver<'a>(
    bus: &'a Bus,
    buffer: &'a mut [u8],
    (width, height): (u16, u16),
) -> Result<Driver<'a>, Failure> {
    let interface = SpiInterface::new(Spi(bus), DataPin(bus), buffer);
    let mut driver = Builder::new(ST7789, interface)
        .display_size(width, height)
        .init(&mut NoDelay)
        .map_err(|_| Failure::Driver)?;
    driver.clear(Rgb565::BLACK).map_err(|_| Failure::Driver)?;
    Ok(driver)
}
