//! Stands as one file and as one picture, from the command line.
#![allow(clippy::unwrap_used, reason = "a test that cannot set its stage has failed")]

mod common;

use common::Desk;
use serde_json::Value;

const FAILED: i32 = 1;
const USAGE: i32 = 2;

/// Small pictures.
const SMALL: [&str; 6] = ["--size", "48x32", "--spp", "2", "--texture-size", "256"];

fn desk() -> Desk {
    let desk = Desk::new();
    std::fs::write(
        desk.path("plan.csv"),
        "x,z,species,seed\n0,0,maple,1\n3,0,tulip,2\n-3,1.5,maple,1\n",
    )
    .unwrap();
    desk
}

/// The description in a GLB file.
fn description(bytes: &[u8]) -> Value {
    let length = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
    serde_json::from_slice(&bytes[20..20 + length]).unwrap()
}

#[test]
fn a_stand_is_one_file_with_a_node_for_each_tree_at_its_place() {
    let desk = desk();
    let stand = ["grow", "--stand", "plan.csv", "--age", "8", "--leaves", "--texture-size", "256"];
    let grow = |more: &[&str]| desk.ok(&[&stand[..], more].concat());
    grow(&["-o", "a.glb", "--preview", "a.png"]);
    let bytes = desk.read("a.glb");
    let file = description(&bytes);
    let nodes = file["nodes"].as_array().unwrap();
    let scene = file["scenes"][0]["nodes"].as_array().unwrap();
    let trees: Vec<&Value> = scene.iter().map(|i| &nodes[i.as_u64().unwrap() as usize]).collect();
    let names: Vec<&str> = trees.iter().map(|node| node["name"].as_str().unwrap()).collect();
    assert_eq!(names, ["0 maple 1", "1 tulip 2", "2 maple 1"]);
    assert_eq!(trees[2]["translation"], serde_json::json!([-3.0, 0.0, 1.5]));
    assert_eq!(trees[1]["extras"]["species"], "tulip");
    // Bark and leaves of two species, each with three pictures.
    assert_eq!(file["materials"].as_array().unwrap().len(), 4);
    assert_eq!(file["images"].as_array().unwrap().len(), 12);
    assert_eq!(&desk.read("a.png")[1..4], b"PNG");

    grow(&["-o", "b.glb", "--threads", "1"]);
    assert!(desk.read("b.glb") == bytes, "any number of threads gives the same file");
    let output = desk.run(&[&stand[..], &["-o", "-"]].concat());
    assert!(output.stdout == bytes, "a stream has what a file has");
    #[cfg(target_os = "linux")]
    {
        let output =
            desk.run(&[&stand[..], &["-q", "-o", "/dev/stdout", "--format", "glb"]].concat());
        assert!(output.stdout == bytes, "so has a pipe with a name");
    }
    grow(&["-o", "c.gltf", "--instancing", "--lods"]);
    let file: Value = serde_json::from_slice(&desk.read("c.gltf")).unwrap();
    assert_eq!(file["extensionsUsed"], serde_json::json!(["EXT_mesh_gpu_instancing", "MSFT_lod"]));
    assert_eq!(file["buffers"][0]["byteLength"], desk.read("c.bin").len());
    assert!(desk.files().iter().all(|name| !name.ends_with(".part")));
}

#[test]
fn the_networks_stands_are_files_and_pictures_too() {
    let desk = Desk::new();
    let plan = "x,z,species,seed\n0,0,maple,1\n3,0,tulip,2\n-3,1.5,maple,3\n";
    std::fs::write(desk.path("plan.csv"), plan).unwrap();
    let stand = ["generate", "--stand", "plan.csv", "--age", "20"];
    desk.ok(&[&stand[..], &["-o", "a.glb", "--max-triangles", "500"]].concat());
    let file = description(&desk.read("a.glb"));
    let accessors = file["accessors"].as_array().unwrap();
    let indices = accessors.iter().filter(|a| a["type"] == "SCALAR");
    let triangles: Vec<u64> = indices.map(|a| a["count"].as_u64().unwrap() / 3).collect();
    assert!(triangles.len() == 3 && triangles.iter().all(|&n| n <= 500), "{triangles:?}");

    desk.ok(&[&stand[..], &["-o", "a.parquet"]].concat());
    let render = |words: &[&str]| desk.ok(&[&["render"], words, &SMALL].concat());
    let said = render(&["a.parquet", "--all", "-o", "a.png", "--aov", "labels"]);
    assert!(said.starts_with("3 trees, "), "{said}");
    let numbers = |name: &str| {
        let bytes = desk.read(name);
        let mut reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info().unwrap();
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut pixels).unwrap();
        let mut numbers: Vec<u16> =
            pixels.as_chunks::<2>().0.iter().map(|b| u16::from_be_bytes(*b)).collect();
        numbers.sort_unstable();
        numbers.dedup();
        numbers
    };
    assert_eq!(numbers("a.tree.png"), [0, 1, 2, 3]);
    std::fs::create_dir(desk.path("folder")).unwrap();
    std::fs::rename(desk.path("a.parquet"), desk.path("folder/a.parquet")).unwrap();
    std::fs::write(desk.path("folder/readme.txt"), "no tree").unwrap();
    render(&["folder", "--all", "-o", "b.png"]);
    assert!(desk.read("a.png") == desk.read("b.png"));

    // A file a tree, each at its place; the picture is of all of them, from a corner.
    desk.ok(&[&stand[..], &["-o", "trees/", "--format", "parquet"]].concat());
    assert_eq!(std::fs::read_dir(desk.path("trees")).unwrap().count(), 3);
    render(&["trees", "--all", "-o", "c.png", "--aov", "labels"]);
    assert!(desk.read("a.png") == desk.read("c.png"));
    assert_eq!(numbers("c.tree.png"), [0, 1, 2, 3]);
    render(&["trees", "--all", "--views", "quarter", "-o", "d.png"]);
    assert!(desk.read("a.png") == desk.read("d.png"));
    // A single tree is looked at from the front.
    render(&["folder/a.parquet", "--tree", "1", "-o", "e.png"]);
    render(&["folder/a.parquet", "--tree", "1", "--views", "front", "-o", "f.png"]);
    assert!(desk.read("e.png") == desk.read("f.png"));
}

#[test]
fn what_is_no_stand_is_refused_in_one_line() {
    let desk = desk();
    let fails = |more: &[&str], part| {
        let words = [&["grow", "--stand", "plan.csv", "--age", "8"][..], more].concat();
        desk.fails(&words, USAGE, part);
    };
    for file in ["a.obj", "a.ply", "a.usda", "a.usdz", "a.tree"] {
        fails(&["-o", file], "a stand as one file is .glb or .gltf");
    }
    fails(&["-o", "a.glb", "--lods", "--impostor"], "--impostor is for one tree a file");
    fails(&["-o", "a.glb", "--animate-growth"], "--animate-growth is for one tree a file");
    fails(&["-o", "a.glb", "--lods=files"], "--lods=files is for one tree a file");
    fails(&["-o", "-", "--format", "gltf"], "has others beside it");
    fails(&["-o", "a.glb", "--preview", "a.exr"], "a preview is a .png");
    let words = ["grow", "--stand", "plan.csv", "--age", "8", "-o", "none/a.glb"];
    desk.fails(&words, FAILED, "none/a.glb was not written");

    desk.ok(&["grow", "maple", "--age", "4", "--count", "2", "-o", "a.csv"]);
    let render = |words: &[&str], code, part| {
        desk.fails(&[&["render"], words, &["-o", "a.png"]].concat(), code, part);
    };
    render(&["a.csv", "--all"], USAGE, "trees 0 and 1 stand at the same place");
    render(&["a.csv", "--all", "--tree", "1"], USAGE, "cannot be used with");
    render(&["a.csv", "--all", "--views", "top,trunk"], USAGE, "the view trunk is of one tree");
    render(&["plan.csv", "--all"], FAILED, "there is no column `id`");
    std::fs::create_dir(desk.path("empty")).unwrap();
    render(&["empty", "--all"], FAILED, "has no .tree .csv .parquet or .dtree in it");
    render(&["nothing.csv", "--all"], FAILED, "cannot read nothing.csv");
}
