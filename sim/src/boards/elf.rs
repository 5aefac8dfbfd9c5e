//! What an image holds.
//!
//! Float instructions are found by decoding: the ELF's mapping symbols (`$t` code, `$d` data; Arm
//! IHI 0044, "Mapping symbols") tell where Thumb instructions are, their first halfword how long
//! they are, and every instruction of the FPU is one of coprocessor 10 or 11 (Arm DDI 0403, A5.3.18
//! and A6). An rv32imac has no such instructions: there arithmetic on floats is a call, and its name
//! stands in the symbol table.

use std::path::Path;
use std::{fs, io};

use object::read::elf::ElfFile32;
use object::{Architecture, Object, ObjectSection, ObjectSymbol, SectionKind};

use super::BoardError;

/// What an image holds.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Contents {
    /// Bytes of code.
    pub code: u64,
    /// Bytes of constants.
    pub constants: u64,
    /// Bytes of initialised variables, in flash and in RAM.
    pub data: u64,
    /// Bytes of variables that start as zero.
    pub zeroed: u64,
    /// Functions that exist only to panic.
    pub panics: Vec<String>,
    /// Functions of an allocator.
    pub allocators: Vec<String>,
    /// Where there is arithmetic on floats: addresses of instructions, names of functions.
    pub floats: Vec<String>,
}

impl Contents {
    /// Looks into an ELF file.
    ///
    /// # Errors
    /// [`BoardError::File`].
    pub fn of(path: &Path) -> Result<Self, BoardError> {
        let failed = |reason: String| BoardError::File {
            file: path.display().to_string(),
            reason,
        };
        let bytes = fs::read(path).map_err(|error: io::Error| failed(error.to_string()))?;
        Self::parse(&bytes).map_err(failed)
    }

    fn parse(bytes: &[u8]) -> Result<Self, String> {
        let file = ElfFile32::<object::Endianness>::parse(bytes).map_err(|e| e.to_string())?;
        let mut contents = Self::default();
        for section in file.sections() {
            let size = section.size();
            match section.kind() {
                SectionKind::Text => contents.code += size,
                SectionKind::ReadOnlyData | SectionKind::ReadOnlyString => {
                    contents.constants += size;
                }
                SectionKind::Data => contents.data += size,
                // The region of the stack is not a variable.
                SectionKind::UninitializedData if section.name() != Ok(".stack") => {
                    contents.zeroed += size;
                }
                _ => {}
            }
        }
        for symbol in file.symbols() {
            let Ok(name) = symbol.name() else { continue };
            if [
                "core9panicking",
                "slice_index_fail",
                "unwrap_failed",
                "expect_failed",
                "rust_begin_unwind",
            ]
            .iter()
            .any(|part| name.contains(part))
            {
                contents.panics.push(name.to_owned());
            }
            if name.contains("__rust_alloc")
                || name.contains("__rg_alloc")
                || name.contains("__rustc12___rust_alloc")
                || name == "malloc"
            {
                contents.allocators.push(name.to_owned());
            }
            if is_soft_float(name) {
                contents.floats.push(name.to_owned());
            }
        }
        match file.architecture() {
            Architecture::Arm => contents.floats.extend(fpu_instructions(&file)?),
            Architecture::Riscv32 => {}
            other => return Err(format!("an ELF file for {other:?}")),
        }
        Ok(contents)
    }

    /// Bytes of flash.
    #[must_use]
    pub fn flash(&self) -> u64 {
        self.code + self.constants + self.data
    }

    /// Bytes of RAM without the stack.
    #[must_use]
    pub fn ram(&self) -> u64 {
        self.data + self.zeroed
    }
}

/// Functions by which compilers do arithmetic on floats without an FPU (the names of libgcc and of
/// Arm IHI 0043).
fn is_soft_float(name: &str) -> bool {
    let gcc = name.strip_prefix("__").is_some_and(|rest| {
        let kind = |ending: &str| {
            [
                "add", "sub", "mul", "div", "neg", "eq", "ne", "lt", "le", "gt", "ge", "unord",
                "cmp",
            ]
            .iter()
            .any(|op| rest.strip_prefix(op) == Some(ending))
        };
        ["sf3", "df3", "sf2", "df2"]
            .iter()
            .any(|ending| kind(ending))
            || rest.starts_with("fix") && rest.len() <= 10
            || rest.starts_with("float") && rest.len() <= 12
            || rest.starts_with("extendsf")
            || rest.starts_with("truncdf")
    });
    let arm = name.strip_prefix("__aeabi_").is_some_and(|rest| {
        rest.starts_with(['f', 'd']) && !rest.starts_with("drsub_")
            || rest.ends_with("2f")
            || rest.ends_with("2d")
    });
    gcc || arm
}

/// Addresses of the instructions of coprocessors 10 and 11.
fn fpu_instructions(file: &ElfFile32<'_, object::Endianness>) -> Result<Vec<String>, String> {
    let mut marks: Vec<(u64, bool)> = file
        .symbols()
        .filter_map(|symbol| match symbol.name().ok()? {
            name if name == "$t" || name.starts_with("$t.") => Some((symbol.address(), true)),
            name if name == "$d" || name.starts_with("$d.") => Some((symbol.address(), false)),
            _ => None,
        })
        .collect();
    marks.sort_unstable();
    let mut found = Vec::new();
    for section in file.sections().filter(|s| s.kind() == SectionKind::Text) {
        let bytes = section.data().map_err(|error| error.to_string())?;
        let (start, end) = (section.address(), section.address() + section.size());
        let inside = marks.iter().filter(|(at, _)| (start..end).contains(at));
        let spans: Vec<_> = inside.copied().collect();
        if !spans.iter().any(|(_, code)| *code) {
            return Err(format!("no mapping symbols at {start:#x}"));
        }
        for (k, (from, code)) in spans.iter().enumerate() {
            if !code {
                continue;
            }
            let to = spans.get(k + 1).map_or(end, |next| next.0);
            let span = bytes.get((from - start) as usize..(to - start) as usize);
            let span = span.ok_or("mapping symbols beyond their section")?;
            found.extend(fpu_in(span).map(|at| format!("{:#x}", from + at as u64)));
        }
    }
    Ok(found)
}

/// Offsets of FPU instructions in Thumb code.
fn fpu_in(code: &[u8]) -> impl Iterator<Item = usize> + '_ {
    let halves = code.as_chunks::<2>().0;
    let mut at = 0;
    std::iter::from_fn(move || {
        while let Some(first) = halves.get(at).copied().map(u16::from_le_bytes) {
            let here = at;
            // 0b11101, 0b11110, 0b11111: two halfwords (A5.1).
            let wide = first >> 11 >= 0b11101;
            at += if wide { 2 } else { 1 };
            let second = halves.get(here + 1).copied().map(u16::from_le_bytes);
            // 111x 11xx: coprocessors (A5.3.18); bits 8 to 11 of the second say which.
            let coprocessor = wide && first & 0xec00 == 0xec00;
            if coprocessor && second.is_some_and(|second| second >> 9 & 7 == 0b101) {
                return Some(2 * here);
            }
        }
        None
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn code(halves: &[u16]) -> Vec<u8> {
        halves.iter().flat_map(|half| half.to_le_bytes()).collect()
    }

    #[test]
    fn instructions_of_the_fpu_are_found() {
        // Arm DDI 0403, A7.7: vadd.f32 s0, s0, s1; vldr s0, [r0]; vcvt.s32.f32 s0, s0; vmov r0, s0;
        // vpush {d8}; vadd.f64 d0, d0, d1.
        let fpu = [
            [0xee30, 0x0a20],
            [0xed90, 0x0a00],
            [0xeebd, 0x0ac0],
            [0xee10, 0x0a10],
            [0xed2d, 0x8b02],
            [0xee30, 0x0b01],
        ];
        for instruction in fpu {
            assert_eq!(fpu_in(&code(&instruction)).count(), 1, "{instruction:x?}");
        }
    }

    #[test]
    fn other_instructions_are_not() {
        // push {r4, lr}; bl; ldrd r0, r1, [r2]; umull r0, r1, r2, r3; movw r0, #0xa00;
        // mcr p15, 0, r0, c7, c5, 4 (another coprocessor); smlal; and a wide instruction whose
        // second half looks like the first half of one of the FPU's.
        let others = [
            0xb510, 0xf000, 0xf800, 0xe9d2, 0x0100, 0xfba2, 0x0103, 0xf640, 0x2000, 0xee07, 0x0f95,
            0xfbc2, 0x0103, 0xf8d0, 0xee30, 0x0a20,
        ];
        assert_eq!(fpu_in(&code(&others)).count(), 0);
    }

    #[test]
    fn names_of_soft_floats() {
        let floats = [
            "__addsf3",
            "__muldf3",
            "__fixunssfsi",
            "__floatunsidf",
            "__aeabi_fadd",
            "__aeabi_i2f",
            "__gtsf2",
            "__truncdfsf2",
        ];
        assert!(floats.iter().all(|name| is_soft_float(name)));
        let others = [
            "__aeabi_uldivmod",
            "__aeabi_memcpy4",
            "__udivdi3",
            "__muldi3",
            "__clzsi2",
            "main",
        ];
        assert!(!others.iter().any(|name| is_soft_float(name)));
    }
}
