//! Materials, textures and pictures of a description.

use std::borrow::Cow;
use std::sync::Arc;

use deeptree_mesh::{Image, Material};
use gltf_json as json;
use json::material::{
    AlphaCutoff, AlphaMode, NormalTexture, PbrBaseColorFactor, PbrMetallicRoughness, StrengthFactor,
};
use json::texture::{Info, MagFilter, MinFilter, Sampler, WrappingMode};
use json::validation::Checked;
use json::{Index, Root};
use serde_json::value::RawValue;

use crate::images::{self, ImageError, Use};
use crate::subject::cutoff;

/// The materials of a description, each once, and the pictures that they need.
#[derive(Default)]
pub(super) struct Materials {
    known: Vec<(Material, Index<json::Material>)>,
    /// In the order of the description's images.
    pub(super) pictures: Vec<Picture>,
}

/// A picture that goes into the file, or beside it.
pub(super) struct Picture {
    /// Material and use, such as `oak bark color`.
    pub(super) name: String,
    pub(super) png: Vec<u8>,
}

/// Does the picture repeat?
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Wrap {
    Repeat,
    Clamp,
}

impl Materials {
    /// The material in the description, which it is added to when it is not there yet.
    pub(super) fn index(
        &mut self,
        root: &mut Root,
        material: &Material,
        wrap: Wrap,
    ) -> Result<Index<json::Material>, ImageError> {
        if let Some(&(_, index)) = self.known.iter().find(|(known, _)| known == material) {
            return Ok(index);
        }
        let index = self.push(root, material, wrap)?;
        self.known.push((material.clone(), index));
        Ok(index)
    }

    fn push(
        &mut self,
        root: &mut Root,
        material: &Material,
        wrap: Wrap,
    ) -> Result<Index<json::Material>, ImageError> {
        let mut texture = |image: &Option<Arc<Image>>, of: Use| match image {
            Some(image) => self.texture(root, material, image, of, wrap).map(Some),
            None => Ok(None),
        };
        let color = texture(&material.color_image, Use::Color)?;
        let normal = texture(&material.normal_image, Use::Normal)?;
        let roughness = texture(&material.roughness_image, Use::Roughness)?;
        // Of the light that goes through leaves, no extension that validators know tells.
        let extras = (material.translucency > 0.0)
            .then(|| serde_json::json!({ "translucency": material.translucency }).to_string())
            .and_then(|text| RawValue::from_string(text).ok());
        let mode =
            if material.alpha_cutoff.is_some() { AlphaMode::Mask } else { AlphaMode::Opaque };
        Ok(root.push(json::Material {
            name: Some(material.name.clone()),
            alpha_cutoff: cutoff(material).map(AlphaCutoff),
            alpha_mode: Checked::Valid(mode),
            double_sided: material.double_sided,
            pbr_metallic_roughness: PbrMetallicRoughness {
                base_color_factor: PbrBaseColorFactor(material.color),
                base_color_texture: color.map(info),
                metallic_factor: StrengthFactor(0.0),
                roughness_factor: StrengthFactor(material.roughness),
                metallic_roughness_texture: roughness.map(info),
                ..PbrMetallicRoughness::default()
            },
            normal_texture: normal.map(|index| NormalTexture {
                index,
                scale: 1.0,
                tex_coord: 0,
                extensions: None,
                extras: None,
            }),
            extras,
            ..json::Material::default()
        }))
    }

    fn texture(
        &mut self,
        root: &mut Root,
        material: &Material,
        image: &Image,
        of: Use,
        wrap: Wrap,
    ) -> Result<Index<json::Texture>, ImageError> {
        let image = match of {
            Use::Roughness => images::as_occlusion_roughness_metal(image),
            Use::Color | Use::Normal => Cow::Borrowed(image),
        };
        let name = format!("{} {}", material.name, of.name());
        self.pictures.push(Picture { name: name.clone(), png: images::png(&image)? });
        // Where it lies is said when the file is written.
        let source = root.push(json::Image {
            name: Some(name),
            mime_type: None,
            buffer_view: None,
            uri: None,
            extensions: None,
            extras: None,
        });
        let sampler = Some(sampler(root, wrap));
        Ok(root.push(json::Texture { name: None, sampler, source, extensions: None, extras: None }))
    }
}

fn info(index: Index<json::Texture>) -> Info {
    Info { index, tex_coord: 0, extensions: None, extras: None }
}

/// The sampler of this kind, which is added when it is not there yet.
fn sampler(root: &mut Root, wrap: Wrap) -> Index<Sampler> {
    let mode = Checked::Valid(match wrap {
        Wrap::Repeat => WrappingMode::Repeat,
        Wrap::Clamp => WrappingMode::ClampToEdge,
    });
    if let Some(at) = root.samplers.iter().position(|sampler| sampler.wrap_s == mode) {
        return Index::new(at as u32);
    }
    root.push(Sampler {
        mag_filter: Some(Checked::Valid(MagFilter::Linear)),
        min_filter: Some(Checked::Valid(MinFilter::LinearMipmapLinear)),
        wrap_s: mode,
        wrap_t: mode,
        ..Sampler::default()
    })
}
