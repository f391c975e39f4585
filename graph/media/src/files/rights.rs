//! Owner, group and mode of files that replace others.

use std::fs::{File, Metadata, OpenOptions};

/// Makes a new file readable for its owner alone until it gets its rights.
#[cfg(unix)]
pub(super) fn private(options: &mut OpenOptions) {
    std::os::unix::fs::OpenOptionsExt::mode(options, 0o600);
}

/// Gives a file the owner, the group and the mode of the one that it replaces. Only root may give files away, so that
/// the owner can change. Rights of a group that cannot be kept become those of all others. Some file systems have
/// neither owners nor modes.
#[cfg(unix)]
pub(super) fn keep_rights(file: &File, old: &Metadata) {
    use std::os::unix::fs::{MetadataExt, PermissionsExt, fchown};
    let Ok(new) = file.metadata() else { return };
    let keeps_group = old.gid() == new.gid() || fchown(file, None, Some(old.gid())).is_ok();
    let keeps_owner = old.uid() == new.uid() || fchown(file, Some(old.uid()), None).is_ok();
    let mode = old.mode();
    let mode = match (keeps_owner, keeps_group) {
        (true, true) => mode & 0o7777,
        (false, true) => mode & 0o777,
        (_, false) => mode & 0o707 | (mode & 0o007) << 3,
    };
    let _ = file.set_permissions(std::fs::Permissions::from_mode(mode));
}

#[cfg(not(unix))]
pub(super) fn private(_: &mut OpenOptions) {}

/// Gives a file the read-only attribute of the one that it replaces.
#[cfg(not(unix))]
pub(super) fn keep_rights(file: &File, old: &Metadata) {
    let _ = file.set_permissions(old.permissions());
}
