//! The simulator as a WebAssembly module.
//!
//! Numbers go in and out as integers and floats, text through the module's memory, and the state of an episode
//! is an array of numbers there. `README.md` has the functions, what they read and what they answer;
//! `cocarry.js` calls them from JavaScript. There is no wasm-bindgen, and the module imports nothing.

mod catalogue;
mod episode;
mod exports;
mod module;
mod parts;
mod robots;
mod state;
mod steering;
mod world;

pub use exports::*;
pub use module::host;
pub use robots::HULLS;
pub use state::javascript;
