//! Recordings as pages and pictures that open anywhere: a 3-D player in one HTML file, filmstrips and
//! animations; and layouts for other viewers.
//!
//! Everything is drawn from what the recording holds, in the colours of `cocarry_output::palette`. Equal
//! recordings give equal bytes.

mod film;
mod format;
mod layout;
mod learned;
mod pdf;
mod pictures;
mod player;
mod robot;
mod take_over;

pub use format::PictureFormat;
pub use layout::viewer_layout;
pub use pdf::pdf;
pub use pictures::{
    Pixels, Width, filmstrip_png, filmstrip_svg, last_picture, moving_gif, png, stimulus_gif, stimulus_png,
};
pub use player::{player, stimulus_page};
pub use robot::robot_page;
pub use take_over::{DEMO_PORT, demo_address};
