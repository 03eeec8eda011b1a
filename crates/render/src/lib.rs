//! A path tracer for a tree or many: wood, translucent leaves, a sky with its sun, and level ground.
//!
//! ```
//! use deeptree_graph::{BranchGraph, ChildSignature, Quat, TreeInfo, Vec3};
//! use deeptree_mesh::{Dressed, WoodOptions, wood};
//! use deeptree_render::{Camera, Ground, Light, Options, Scene, View, render};
//!
//! let info = TreeInfo { species: "oak".into(), age: 1, gravitropism: 0.0, seed: 0 };
//! let upright = Quat::from_rotation_x(std::f32::consts::FRAC_PI_2);
//! let edge = ChildSignature { rotation: upright, thickness: 0.1, length: 2.0 };
//! let post = wood(&BranchGraph::new(info, Vec3::ZERO, edge), &WoodOptions::default());
//! let tree = Dressed { wood: post, bark: deeptree_render::plain_bark(), foliage: Vec::new() };
//! let scene = Scene::new(&tree, Light::daylight(0.7, -0.6, 3.0)?, Ground::Meadow)?;
//! let camera = Camera::framing(scene.points(), View::Front, 1.0, 0.5)?;
//! let options = Options { size: [32, 32], samples: 4, ..Options::default() };
//! let picture = render(&scene, &camera, &options, |_| ())?;
//! assert!(picture.mean()[1] > 0.1);
//! # Ok::<(), deeptree_render::RenderError>(())
//! ```
//!
//! The same scene and seed give the same bits for any number of threads.

#![forbid(unsafe_code)]

mod aov;
mod bark;
mod bsdf;
mod camera;
mod develop;
mod error;
pub mod files;
mod film;
mod geometry;
mod ggx;
mod ground;
mod grove;
mod impostor;
mod integrator;
mod light;
mod mosaic;
mod ray;
mod sampler;
mod scene;
mod sky;

mod texture;
mod tone;

pub use aov::{Kind, Mark, marks};
pub use bark::plain_bark;
pub use camera::{Camera, View};
pub use develop::{Background, Developing, develop};
pub use error::RenderError;
pub use film::{MAX_SAMPLES, MAX_SIZE, Options, Picture, render, tile_count};
pub use ground::Ground;
pub use impostor::{Card, Impostor, impostor};
pub use light::Light;
pub use mosaic::Mosaic;
pub use scene::{Scene, Standing, points};
pub use tone::Tone;
