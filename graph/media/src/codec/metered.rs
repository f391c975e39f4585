//! A reader of headers, which have no stated length.

use std::cell::Cell;
use std::io::{Error, ErrorKind, Read, Result, Seek, SeekFrom};
use std::rc::Rc;

/// The number of bytes that may still be read; shared by the reader and its owner.
#[derive(Clone)]
pub(super) struct Allowance(Rc<Cell<u64>>);

impl Allowance {
    /// Lets the reader read the rest of the file.
    pub(super) fn lift(&self) {
        self.0.set(u64::MAX);
    }
}

/// A reader that fails after a number of bytes, until its allowance is lifted.
pub(super) struct Metered<R> {
    inner: R,
    left: Allowance,
}

impl<R> Metered<R> {
    /// At most `bytes` are read from `inner`.
    pub(super) fn new(inner: R, bytes: u64) -> (Self, Allowance) {
        let left = Allowance(Rc::new(Cell::new(bytes)));
        (Self { inner, left: left.clone() }, left)
    }
}

impl<R: Read> Read for Metered<R> {
    fn read(&mut self, buffer: &mut [u8]) -> Result<usize> {
        let left = self.left.0.get();
        if left == 0 && !buffer.is_empty() {
            return Err(Error::from(ErrorKind::FileTooLarge));
        }
        let most = buffer.len().min(usize::try_from(left).unwrap_or(usize::MAX));
        let read = self.inner.read(&mut buffer[..most])?;
        self.left.0.set(left - read as u64);
        Ok(read)
    }
}

impl<R: Seek> Seek for Metered<R> {
    fn seek(&mut self, to: SeekFrom) -> Result<u64> {
        // After the header only an empty entry of a table of blocks leads back to it.
        if self.left.0.get() > u64::MAX / 2 && to == SeekFrom::Start(0) {
            return Err(Error::other(Unfinished));
        }
        self.inner.seek(to)
    }
}

/// A block that was never written.
#[derive(Debug)]
pub(super) struct Unfinished;

impl std::fmt::Display for Unfinished {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("a block was never written")
    }
}

impl std::error::Error for Unfinished {}
