//! The three semihosting calls that files need (ARM, "Semihosting for AArch32 and AArch64",
//! 2025Q1). The crate's own `File` asserts that its handle is not −1 whenever it is used, which
//! would be a panic path.

use crate::Failure;
use core::ffi::CStr;
use semihosting::fd::RawFd;
use semihosting::sys::arm_compat::syscall::{
    OperationNumber, ParamRegR, ParamRegW, syscall, syscall_readonly,
};

/// How a file is opened.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Mode {
    /// `rb`
    Read = 1,
    /// `wb`
    Write = 5,
}

/// An open file of the host, closed at the latest when the emulator ends.
pub(crate) struct Handle(RawFd);

impl Drop for Handle {
    fn drop(&mut self) {
        let block = [ParamRegR::raw_fd(self.0)];
        // SAFETY: SYS_CLOSE reads a block of one word.
        #[expect(unsafe_code, reason = "semihosting")]
        unsafe {
            syscall_readonly(OperationNumber::SYS_CLOSE, ParamRegR::block(&block));
        }
    }
}

impl Handle {
    pub(crate) fn open(name: &CStr, mode: Mode) -> Result<Self, Failure> {
        let block = [
            ParamRegR::c_str(name),
            ParamRegR::usize(mode as usize),
            ParamRegR::c_str_len(name),
        ];
        // SAFETY: SYS_OPEN reads a name of the given length, which ends in a zero.
        #[expect(unsafe_code, reason = "semihosting")]
        let answer =
            unsafe { syscall_readonly(OperationNumber::SYS_OPEN, ParamRegR::block(&block)) };
        answer.raw_fd().map(Self).ok_or(Failure::File)
    }

    /// Reads up to `buffer` full; the number of bytes, 0 at the end of the file.
    pub(crate) fn read(&self, buffer: &mut [u8]) -> Result<usize, Failure> {
        let len = buffer.len();
        let mut block = [
            ParamRegW::raw_fd(self.0),
            ParamRegW::buf(buffer),
            ParamRegW::usize(len),
        ];
        // SAFETY: SYS_READ writes at most `len` bytes at the start of the buffer.
        #[expect(unsafe_code, reason = "semihosting")]
        let answer = unsafe { syscall(OperationNumber::SYS_READ, ParamRegW::block(&mut block)) };
        // The answer is what was not read.
        len.checked_sub(answer.usize()).ok_or(Failure::File)
    }

    pub(crate) fn write(&self, bytes: &[u8]) -> Result<(), Failure> {
        let block = [
            ParamRegR::raw_fd(self.0),
            ParamRegR::buf(bytes),
            ParamRegR::usize(bytes.len()),
        ];
        // SAFETY: SYS_WRITE reads the buffer.
        #[expect(unsafe_code, reason = "semihosting")]
        let answer =
            unsafe { syscall_readonly(OperationNumber::SYS_WRITE, ParamRegR::block(&block)) };
        // The answer is what was not written.
        if answer.usize() == 0 {
            Ok(())
        } else {
            Err(Failure::File)
        }
    }
}
