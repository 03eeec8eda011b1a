//! Pictures, from the command to their files.
#![allow(clippy::unwrap_used, reason = "a test that cannot set its stage has failed")]

mod common;

use common::Desk;

const FAILED: i32 = 1;
const USAGE: i32 = 2;

/// A post of one node.
const POST: &str = "tree,id,parent,x,y,z,radius,order,slot,length,qx,qy,qz,qw\n\
                    0,0,-1,0,2,0,0.1,0,0,2,0.70710677,0,0,0.70710677\n";

/// Width and height of a PNG, by its header.
fn png_size(bytes: &[u8]) -> [u32; 2] {
    assert_eq!(&bytes[..8], b"\x89PNG\r\n\x1a\n");
    [16, 20].map(|at| u32::from_be_bytes(bytes[at..at + 4].try_into().unwrap()))
}

fn desk_with_post() -> Desk {
    let desk = Desk::new();
    std::fs::write(desk.path("post.csv"), POST).unwrap();
    desk
}

#[test]
fn a_tree_of_one_node_is_pictured_from_all_sides() {
    let desk = desk_with_post();
    let small = ["--size", "24x16", "--spp", "4", "--texture-size", "256"];
    let render = |words: &[&str]| desk.ok(&[&["render", "post.csv"], words, &small].concat());
    render(&["-o", "a.png", "--views", "front,top,quarter,left", "--aov", "depth,normal,labels"]);
    for name in ["a.png", "a.depth.png", "a.normal.png", "a.kind.png", "a.order.png", "a.node.png"]
    {
        // Three in a row, with gaps of four pixels.
        assert_eq!(png_size(&desk.read(name)), [3 * 24 + 2 * 4, 2 * 16 + 4], "{name}");
    }
    for background in ["sky", "white", "transparent"] {
        render(&["-o", "b.png", "--background", background]);
        assert_eq!(png_size(&desk.read("b.png")), [24, 16]);
    }
    render(&["-o", "c.exr", "--aov", "depth"]);
    assert_eq!(desk.read("c.exr")[..4], [0x76, 0x2f, 0x31, 0x01]);
    let before = desk.read("c.exr");
    render(&["-o", "c.exr", "--aov", "depth", "--threads", "1"]);
    assert!(before == desk.read("c.exr"), "any number of threads gives the same picture");
    render(&["-o", "card.png", "--impostor=3"]);
    assert_eq!(png_size(&desk.read("card.png")), png_size(&desk.read("card.normal.png")));
}

#[test]
fn generate_and_grow_write_a_preview() {
    let desk = Desk::new();
    for verb in ["generate", "grow"] {
        desk.ok(&[verb, "tulip", "-o", "t.csv", "--preview", "t.png", "--texture-size", "256"]);
        assert_eq!(png_size(&desk.read("t.png")), [512, 512]);
        desk.fails(&[verb, "tulip", "-o", "u.csv", "--preview", "t.gif"], USAGE, ".png or .exr");
    }
}

#[test]
fn a_sheet_is_made_with_one_command() {
    let desk = Desk::new();
    let words = ["--sheet", "views", "--species", "tulip", "--size", "40x40", "--spp", "2"];
    desk.ok(
        &[&["render", "-o", "s.png", "--texture-size", "256", "--lod", "3"], &words[..]].concat()
    );
    let [width, height] = png_size(&desk.read("s.png"));
    assert!(width > 8 * 20 && height > 40, "{width} {height}");
}

#[test]
fn pictures_that_cannot_be_are_refused() {
    let desk = desk_with_post();
    std::fs::write(desk.path("empty.csv"), "").unwrap();
    std::fs::write(desk.path("empty.dtree"), "").unwrap();
    desk.fails(&["render", "empty.csv", "-o", "a.png"], FAILED, "empty.csv");
    desk.fails(&["render", "empty.dtree", "-o", "a.png"], FAILED, "empty.dtree");
    desk.fails(&["render", "none.csv", "-o", "a.png"], FAILED, "none.csv");
    desk.fails(&["render", "-o", "a.png"], USAGE, "required");
    let post = |words: &[&str], part| {
        desk.fails(&[&["render", "post.csv"], words].concat(), USAGE, part);
    };
    post(&["-o", "a.jpg"], ".png or .exr");
    post(&["-o", "a.png", "--views", "front,sideways"], "'sideways'; there are front");
    for size in ["0x10", "10", "10x", "99999x10", "-1x3"] {
        post(&["-o", "a.png", &format!("--size={size}")], "is no size");
    }
    post(&["-o", "a.png", "--spp", "0"], "--spp");
    post(&["-o", "a.png", "--error=-1"], "the error is -1");
    post(&["-o", "a.png", "--sun", "-5,0"], "the sun stands at");
    post(&["-o", "a.png", "--sun", "5"], "2 numbers");
    post(&["-o", "a.png", "--haze", "1"], "the turbidity is 1");
    post(&["-o", "a.png", "--angle", "180"], "the angle of view");
    post(&["-o", "a.png", "--lod", "9"], "--lod");
    post(&["-o", "a.png", "--aov", "smell"], "smell");
    post(&["-o", "a.png", "--texture-size", "0"], "texture size");
    post(&["-o", "a.exr", "--impostor"], "name a .png");
    desk.fails(&["render", "--sheet", "species", "-o", "s.exr"], USAGE, "name a .png");
    let elm = ["render", "--sheet", "views", "--species", "elm", "-o", "s.png"];
    desk.fails(&elm, USAGE, "'elm'");
}
