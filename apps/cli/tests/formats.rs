//! Every format of surfaces, its files, and what they cannot have.

mod common;

use common::Desk;

const USAGE: i32 = 2;
const SMALL: [&str; 6] = ["generate", "oak", "--seed", "7", "--max-triangles", "3000"];

fn generate(desk: &Desk, more: &[&str]) {
    desk.ok(&[&SMALL, more].concat());
}

#[test]
fn formats_write_the_files_that_belong_together() {
    let desk = Desk::new();
    generate(&desk, &["-o", "a.gltf"]);
    generate(&desk, &["-o", "b.obj"]);
    generate(&desk, &["-o", "c.usda"]);
    generate(&desk, &["-o", "d.usdz"]);
    generate(&desk, &["-o", "e.ply"]);
    let files = ["a.bin", "a.gltf", "b.mtl", "b.obj", "c.usda", "d.usdz", "e.ply"];
    assert_eq!(desk.files(), files);
    let text = String::from_utf8_lossy(&desk.read("b.obj")).into_owned();
    assert!(text.contains("\nmtllib b.mtl\n") && text.contains("\nusemtl wood\n"));
    assert!(String::from_utf8_lossy(&desk.read("b.mtl")).contains("\nnewmtl wood\n"));
    assert!(desk.read("c.usda").starts_with(b"#usda 1.0\n"));
    assert!(desk.read("d.usdz").starts_with(b"PK\x03\x04"));
}

#[test]
fn a_stream_gets_what_needs_no_file_beside_it() {
    let desk = Desk::new();
    for (format, magic) in
        [("glb", &b"glTF"[..]), ("obj", b"# Dee"), ("usdz", b"PK"), ("ply", b"ply")]
    {
        let words = [&SMALL[..], &["-q", "--format", format, "-o", "-"]].concat();
        let output = desk.run(&words);
        assert!(output.status.success() && output.stdout.starts_with(magic), "{format}");
    }
    for format in ["gltf", "usda"] {
        let words = [&SMALL[..], &["--format", format, "-o", "-"]].concat();
        desk.fails(&words, USAGE, "others beside it");
    }
    desk.fails(&["grow", "oak", "--lods", "--format", "obj", "-o", "-"], USAGE, "others beside it");
}

#[test]
fn levels_of_detail_are_in_one_file_or_in_four() {
    let desk = Desk::new();
    let oak = |more: &[&str]| desk.ok(&[&["generate", "oak", "--seed", "7"], more].concat());
    oak(&["--lods", "-o", "one.glb"]);
    assert_eq!(desk.files(), ["one.glb"]);
    let one = desk.read("one.glb");
    let length = u32::from_le_bytes([one[12], one[13], one[14], one[15]]) as usize;
    let text = String::from_utf8_lossy(&one[20..20 + length]).into_owned();
    assert!(text.contains("\"MSFT_lod\":{\"ids\":[1,2,3]}"), "{text}");
    oak(&["--lods=files", "-o", "four.glb"]);
    let sizes = [0, 1, 2, 3].map(|lod| desk.read(&format!("four_lod{lod}.glb")).len());
    assert!(sizes.is_sorted_by(|a, b| a > b), "{sizes:?}");
    assert_eq!(desk.files().len(), 5);
}

#[test]
fn what_a_format_cannot_have_is_refused() {
    let desk = Desk::new();
    for (words, part) in [
        (&["--animate-growth", "-o", "a.obj"][..], "for .glb and .gltf, not for .obj"),
        (&["--animate-growth=0", "-o", "a.glb"], "give 0.1 to 3600"),
        (&["--animate-growth=NaN", "-o", "a.glb"], "finite"),
        (&["--animate-growth", "--instancing", "-o", "a.glb"], "cannot be used with"),
        (&["--animate-growth", "--lods", "-o", "a.glb"], "cannot be used with"),
        (&["--lods", "--lod", "2", "-o", "a.glb"], "cannot be used with"),
        (&["--lods=some", "-o", "a.glb"], "some"),
        (&["--lod", "9", "-o", "a.gltf"], "--lod"),
        (&["-o", "a.usd"], "there is no format '.usd'"),
    ] {
        desk.fails(&[&["generate", "oak"], words].concat(), USAGE, part);
    }
    for name in ["missing/a.gltf", "missing/a.obj", "missing/a.usda", "missing/a.usdz"] {
        desk.fails(&["generate", "oak", "-o", name], 1, "missing/a");
    }
}
