//! Materials as `UsdPreviewSurface`, with the pictures as `UsdUVTexture`.

use std::io::{self, Write};

use deeptree_mesh::{Image, Material};

use super::text::identifier;
use crate::images::Use;
use crate::subject::{Subject, cutoff};

/// A picture of a material.
pub(super) struct Picture<'a> {
    pub(super) image: &'a Image,
    pub(super) material: &'a str,
    /// Material and use, such as `oak bark color`.
    pub(super) name: String,
}

/// The pictures of a material with their use.
fn uses(material: &Material) -> impl Iterator<Item = (Use, &Image)> {
    let all = [
        (Use::Color, &material.color_image),
        (Use::Normal, &material.normal_image),
        (Use::Roughness, &material.roughness_image),
    ];
    all.into_iter().filter_map(|(of, image)| Some((of, image.as_deref()?)))
}

fn picture_name(material: &Material, of: Use) -> String {
    format!("{} {}", material.name, of.name())
}

/// All pictures of a tree.
pub(super) fn pictures(subject: Subject<'_>) -> impl Iterator<Item = Picture<'_>> {
    subject.materials().into_iter().flat_map(|material| {
        uses(material).map(|(of, image)| Picture {
            image,
            material: &material.name,
            name: picture_name(material, of),
        })
    })
}

/// Writes the scope of all materials; `file` says where the picture of a name is.
pub(super) fn write(
    subject: Subject<'_>,
    tree: &str,
    file: &dyn Fn(&str) -> String,
    out: &mut impl Write,
) -> io::Result<()> {
    writeln!(out, "    def Scope \"materials\"\n    {{")?;
    for material in subject.materials() {
        write_material(material, tree, file, out)?;
    }
    writeln!(out, "    }}")
}

fn write_material(
    material: &Material,
    tree: &str,
    file: &dyn Fn(&str) -> String,
    out: &mut impl Write,
) -> io::Result<()> {
    let name = identifier(&material.name);
    let place = format!("/{tree}/materials/{name}");
    writeln!(out, "        def Material \"{name}\"\n        {{")?;
    writeln!(
        out,
        "            token outputs:surface.connect = <{place}/surface.outputs:surface>\n"
    )?;
    write_surface(material, &place, out)?;
    if uses(material).next().is_some() {
        writeln!(out, "            def Shader \"st\"\n            {{")?;
        writeln!(out, "                uniform token info:id = \"UsdPrimvarReader_float2\"")?;
        writeln!(out, "                string inputs:varname = \"st\"")?;
        writeln!(out, "                float2 outputs:result\n            }}")?;
    }
    for (of, _) in uses(material) {
        let path = file(&picture_name(material, of));
        write_texture(material, of, &place, &path, out)?;
    }
    writeln!(out, "        }}\n")
}

/// The surface's own shader: what has a picture is connected to it.
fn write_surface(material: &Material, place: &str, out: &mut impl Write) -> io::Result<()> {
    let has = |wanted| uses(material).any(|(of, _)| of == wanted);
    writeln!(out, "            def Shader \"surface\"\n            {{")?;
    let mut line = |text: std::fmt::Arguments<'_>| writeln!(out, "                {text}");
    let [red, green, blue, alpha] = material.color;
    let cut = cutoff(material);
    line(format_args!("uniform token info:id = \"UsdPreviewSurface\""))?;
    if has(Use::Color) {
        line(format_args!("color3f inputs:diffuseColor.connect = <{place}/color.outputs:rgb>"))?;
    } else {
        line(format_args!("color3f inputs:diffuseColor = ({red}, {green}, {blue})"))?;
    }
    line(format_args!("float inputs:metallic = 0"))?;
    if has(Use::Normal) {
        line(format_args!("normal3f inputs:normal.connect = <{place}/normal.outputs:rgb>"))?;
    }
    if has(Use::Color) && cut.is_some() {
        line(format_args!("float inputs:opacity.connect = <{place}/color.outputs:a>"))?;
    } else {
        line(format_args!("float inputs:opacity = {alpha}"))?;
    }
    if let Some(cut) = cut {
        line(format_args!("float inputs:opacityThreshold = {cut}"))?;
    }
    if has(Use::Roughness) {
        line(format_args!("float inputs:roughness.connect = <{place}/roughness.outputs:r>"))?;
    } else {
        line(format_args!("float inputs:roughness = {}", material.roughness))?;
    }
    line(format_args!("token outputs:surface"))?;
    writeln!(out, "            }}\n")
}

fn write_texture(
    material: &Material,
    of: Use,
    place: &str,
    path: &str,
    out: &mut impl Write,
) -> io::Result<()> {
    writeln!(out, "\n            def Shader \"{}\"\n            {{", of.name())?;
    let mut line = |text: std::fmt::Arguments<'_>| writeln!(out, "                {text}");
    line(format_args!("uniform token info:id = \"UsdUVTexture\""))?;
    if of == Use::Normal {
        line(format_args!("float4 inputs:bias = (-1, -1, -1, 0)"))?;
    }
    line(format_args!("asset inputs:file = @{path}@"))?;
    let [red, green, blue, alpha] = material.color;
    match of {
        Use::Color => {
            line(format_args!("float4 inputs:scale = ({red}, {green}, {blue}, {alpha})"))?
        }
        Use::Normal => line(format_args!("float4 inputs:scale = (2, 2, 2, 1)"))?,
        Use::Roughness => {
            let r = material.roughness;
            line(format_args!("float4 inputs:scale = ({r}, {r}, {r}, 1)"))?;
        }
    }
    let space = if of == Use::Color { "sRGB" } else { "raw" };
    line(format_args!("token inputs:sourceColorSpace = \"{space}\""))?;
    line(format_args!("float2 inputs:st.connect = <{place}/st.outputs:result>"))?;
    // Bark repeats; of a leaf, what lies beyond the picture must not come in from the other side.
    let wrap = if material.alpha_cutoff.is_some() { "clamp" } else { "repeat" };
    line(format_args!("token inputs:wrapS = \"{wrap}\""))?;
    line(format_args!("token inputs:wrapT = \"{wrap}\""))?;
    line(format_args!(
        "float outputs:a\n                float outputs:r\n                float3 outputs:rgb"
    ))?;
    writeln!(out, "            }}")
}
