//! Tests of the linker, of reflection and of the limits of untrusted files, with naga as the judge.
#![allow(unreachable_pub, missing_docs, dead_code, reason = "tests on a device use all of `hostile`")]

mod banded;
mod costs;
mod hostile;
mod isolation;
mod linker;
mod reflected;
mod told;
mod uniform;
mod untrusted;
mod workgroups;
