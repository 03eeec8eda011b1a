//! What can be wrong with a picture that is asked for.

/// Why there is no picture.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum RenderError {
    #[error("there is nothing to look at: the tree has no surface")]
    Empty,
    #[error("a picture of {width} × {height} pixels; give 1 to {most} a side", most = crate::MAX_SIZE)]
    Size { width: u32, height: u32 },
    #[error("{samples} samples a pixel; give 1 to {most}", most = crate::MAX_SAMPLES)]
    Samples { samples: u32 },
    #[error("the sun stands at {elevation}°; it must be above the horizon, from 1° to 90°")]
    Sun { elevation: f32 },
    #[error("{what} is {value}; it must be a number from {low} to {high}")]
    Range { what: &'static str, value: f32, low: f32, high: f32 },
    #[error("vertex {vertex} of {part} is not finite; mend the tree or the mesh")]
    NotFinite { part: &'static str, vertex: usize },
    #[error("a triangle of {part} names vertex {vertex} of {count}; mend the mesh")]
    Index { part: &'static str, vertex: u32, count: usize },
    #[error(
        "the {what} image of {material} has {bytes} bytes for {width} × {height} pixels of \
         {channels} channels; mend the material"
    )]
    Image {
        material: String,
        what: &'static str,
        width: u32,
        height: u32,
        channels: u8,
        bytes: usize,
    },
    #[error("there is no view '{name}'; there are {known}")]
    View { name: String, known: String },
}
