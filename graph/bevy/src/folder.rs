//! Kinds of nodes in folders of assets.

use std::collections::BTreeSet;

use afterimage::Error;
use afterimage::host::NodeKind;
use afterimage::node::folder_kind_sharing;
use afterimage::node::wgsl::imports;
use bevy::asset::{AssetPath, LoadContext};

use crate::asset::{read_bytes, text};

/// The path of a file and its text.
type File = (String, String);

/// The kind in a folder: its `node.ron`, the shader that is named like the folder, and what these import. Assets cannot
/// be listed everywhere, so only files that are imported are read.
pub(crate) async fn kind(folder: &str, context: &mut LoadContext<'_>) -> Result<NodeKind, Error> {
    let (parent, name) = folder.rsplit_once('/').map_or((None, folder), |(parent, name)| (Some(parent), name));
    let library = parent.map_or("lib".to_owned(), |parent| format!("{parent}/lib"));
    let declaration = read(format!("{folder}/node.ron"), context).await?;
    let shader = read(format!("{folder}/{name}.wgsl"), context).await?;
    let mut unread = imported(&shader, folder, &library);
    let (mut own, mut shared) = (vec![shader], Vec::new());
    let mut asked = BTreeSet::new();
    while let Some(path) = unread.pop() {
        if !asked.insert(path.clone()) {
            continue;
        }
        // A file that cannot be read is an error with the location of its import.
        let place = if path.starts_with(&format!("{library}/")) { &*library } else { folder };
        if let Ok(file) = read(path, context).await {
            unread.extend(imported(&file, place, &library));
            if place == folder { own.push(file) } else { shared.push(file) }
        }
    }
    let [own, shared] = [&own, &shared].map(|files| files.iter().map(borrowed).collect::<Vec<_>>());
    Ok(folder_kind_sharing(borrowed(&declaration), &own, &shared)?)
}

/// The paths of the files that a shader in a folder imports, but those of the framework's library.
fn imported((_, text): &File, folder: &str, library: &str) -> Vec<String> {
    let file = |path: String| {
        let shared = path.strip_prefix("package::lib::").map(|rest| (library, rest));
        let (folder, rest) = shared.or_else(|| Some((folder, path.strip_prefix("super::")?)))?;
        Some(format!("{folder}/{}.wgsl", rest.split("::").next()?))
    };
    imports(text).into_iter().filter_map(file).collect()
}

fn borrowed((path, text): &File) -> (&str, &str) {
    (path, text)
}

async fn read(path: String, context: &mut LoadContext<'_>) -> Result<File, Error> {
    let bytes = match AssetPath::try_parse(&path) {
        Ok(parsed) => read_bytes(parsed, context).await,
        Err(error) => Err(error.to_string()),
    };
    let bytes = bytes.map_err(|error| Error::Unreadable(format!("{path}: {error}")))?;
    let text = text(&path, bytes)?;
    Ok((path, text))
}
