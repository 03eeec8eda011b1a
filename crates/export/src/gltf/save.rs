//! Writing a description: into one binary file, or with its numbers and pictures beside it.

use std::io::{self, BufWriter, Write};
use std::path::Path;

use gltf_json as gltf;

use super::container::write_head;
use super::document::{Document, Out};
use super::{GltfError, json};
use crate::atomic::write_atomically;
use crate::beside::Beside;

impl Document<'_> {
    /// Writes the tree as binary glTF, with the pictures in it.
    ///
    /// # Errors
    ///
    /// When the file would pass the 4 GiB that the format can count, or the output fails.
    pub fn write_glb(mut self, out: &mut impl Write) -> Result<(), GltfError> {
        self.embed_pictures();
        let text = self.text_with_buffer(None)?;
        let mut out: Out<'_> = BufWriter::with_capacity(1 << 16, out);
        write_head(text, self.bytes, &mut out)?;
        self.write_blocks(&mut out)?;
        Ok(out.flush()?)
    }

    /// Makes the pictures parts of the buffer.
    pub(super) fn embed_pictures(&mut self) {
        for (i, picture) in std::mem::take(&mut self.materials.pictures).into_iter().enumerate() {
            let bytes = picture.png.len() as u64;
            let view = self.push_view(bytes, None, move |out| out.write_all(&picture.png));
            let image = &mut self.root.images[i];
            image.buffer_view = Some(view);
            image.mime_type = Some(gltf::image::MimeType("image/png".to_owned()));
        }
    }

    /// The description as text; the buffer is in the file of this name, or follows.
    pub(super) fn text_with_buffer(&mut self, name: Option<&str>) -> Result<Vec<u8>, GltfError> {
        if self.bytes > 0 {
            self.root.buffers = vec![json::buffer(self.bytes, name.map(percent_encoded))];
        }
        let text = match name {
            None => gltf::serialize::to_vec(&self.root),
            Some(_) => gltf::serialize::to_vec_pretty(&self.root),
        };
        Ok(text.map_err(io::Error::from)?)
    }

    /// Writes the tree as `.gltf`, with a `.bin` and a PNG for each picture beside it, named after
    /// it. Each of them appears whole or not at all, the description last.
    ///
    /// # Errors
    ///
    /// When the name is no UTF-8, or a file cannot be written.
    pub fn save(self, path: &Path) -> Result<(), GltfError> {
        self.save_with(path, |_| Ok(()))
    }

    /// The same, with what `first` writes at the start of the buffer, whose bytes are counted
    /// already.
    pub(super) fn save_with(
        mut self,
        path: &Path,
        first: impl FnOnce(&mut Out<'_>) -> io::Result<()>,
    ) -> Result<(), GltfError> {
        let beside = Beside::new(path)?;
        for (image, picture) in self.root.images.iter_mut().zip(&self.materials.pictures) {
            let name = beside.picture(&picture.name);
            write_atomically(&beside.path(&name), |out| out.write_all(&picture.png))?;
            image.uri = Some(percent_encoded(&name));
        }
        let name = beside.name(".bin");
        if self.bytes > 0 {
            let fill = |out: &mut BufWriter<_>| {
                let mut out: Out<'_> = BufWriter::with_capacity(1 << 16, out);
                first(&mut out)?;
                self.write_blocks(&mut out)?;
                out.flush()
            };
            write_atomically(&beside.path(&name), fill)?;
        }
        let text = self.text_with_buffer(Some(&name))?;
        Ok(write_atomically(path, |out| out.write_all(&text))?)
    }
}

/// A file's name as a relative address.
///
/// # Source
///
/// RFC 3986, §2.
fn percent_encoded(name: &str) -> String {
    let mut address = String::with_capacity(name.len());
    for byte in name.bytes() {
        if byte.is_ascii_alphanumeric() || b"-._~".contains(&byte) {
            address.push(byte as char);
        } else {
            address.push_str(&format!("%{byte:02X}"));
        }
    }
    address
}
