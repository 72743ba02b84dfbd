//! The functions of the module, with the types that WebAssembly has. `README.md` describes them.
#![allow(unsafe_code, reason = "the attribute that keeps a function's name")]
#![allow(missing_docs, reason = "README.md has a table of them")]

use crate::episode::Open;
use crate::module::{self, bytes, json, with_module};
use crate::{catalogue, parts, robots, world};
use cocarry::scenario::EpisodeLog;

#[unsafe(no_mangle)]
pub extern "C" fn cocarry_input(length: usize) -> *mut u8 {
    module::input(length)
}

#[unsafe(no_mangle)]
pub extern "C" fn cocarry_output() -> *const u8 {
    module::output().0
}

#[unsafe(no_mangle)]
pub extern "C" fn cocarry_output_length() -> usize {
    module::output().1
}

#[unsafe(no_mangle)]
pub extern "C" fn cocarry_catalogue() -> u32 {
    json(|_| Ok(catalogue::catalogue()))
}

#[unsafe(no_mangle)]
pub extern "C" fn cocarry_arithmetic() -> u32 {
    json(|_| Ok(catalogue::arithmetic()))
}

#[unsafe(no_mangle)]
pub extern "C" fn cocarry_world() -> u32 {
    json(|module| world::world(module.take_json("the request of a world")?))
}

#[unsafe(no_mangle)]
pub extern "C" fn cocarry_scenario() -> u32 {
    json(|module| parts::scenario(module.take_json("the parts of a scenario")?))
}

#[unsafe(no_mangle)]
pub extern "C" fn cocarry_robot() -> u32 {
    json(|module| robots::describe(module.take_json("the request of a robot")?))
}

#[unsafe(no_mangle)]
pub extern "C" fn cocarry_open() -> u32 {
    with_module(0, |module| {
        let text = module.take_text("the scenario")?;
        let open = Open::of_scenario(&text)?;
        module.open(open)
    })
}

#[unsafe(no_mangle)]
pub extern "C" fn cocarry_restore() -> u32 {
    with_module(0, |module| {
        let open = Open::of_snapshot(&module.take_bytes())?;
        module.open(open)
    })
}

#[unsafe(no_mangle)]
pub extern "C" fn cocarry_replay() -> u32 {
    with_module(0, |module| {
        let log: EpisodeLog = module.take_json("the log")?;
        let open = Open::of_log(&log)?;
        module.open(open)
    })
}

#[unsafe(no_mangle)]
pub extern "C" fn cocarry_close(handle: u32) -> u32 {
    with_module(0, |module| module.close(handle))
}

#[unsafe(no_mangle)]
pub extern "C" fn cocarry_describe(handle: u32) -> u32 {
    json(|module| Ok(module.episode(handle)?.describe()))
}

#[unsafe(no_mangle)]
pub extern "C" fn cocarry_state(handle: u32) -> *const f64 {
    with_module(std::ptr::null(), |module| Ok(module.episode(handle)?.state().as_ptr()))
}

#[unsafe(no_mangle)]
pub extern "C" fn cocarry_human(handle: u32, option: i32, stance: i32) -> u32 {
    with_module(0, |module| module.episode(handle)?.steer_human(option, stance))
}

#[unsafe(no_mangle)]
pub extern "C" fn cocarry_hand(handle: u32, x: f64, y: f64) -> u32 {
    with_module(0, |module| module.episode(handle)?.steer_hand(x, y))
}

#[unsafe(no_mangle)]
pub extern "C" fn cocarry_policy(handle: u32, lead: i32, option: i32) -> u32 {
    with_module(0, |module| module.episode(handle)?.steer_policy(lead, option))
}

#[unsafe(no_mangle)]
pub extern "C" fn cocarry_period(handle: u32) -> i32 {
    with_module(-1, |module| Ok(module.episode(handle)?.period()))
}

#[unsafe(no_mangle)]
pub extern "C" fn cocarry_step(handle: u32) -> i32 {
    with_module(-1, |module| Ok(module.episode(handle)?.step()))
}

#[unsafe(no_mangle)]
pub extern "C" fn cocarry_run(handle: u32, seconds: f64) -> i32 {
    with_module(-1, |module| module.episode(handle)?.run(seconds))
}

#[unsafe(no_mangle)]
pub extern "C" fn cocarry_events(handle: u32) -> u32 {
    json(|module| Ok(module.episode(handle)?.events()))
}

#[unsafe(no_mangle)]
pub extern "C" fn cocarry_path(handle: u32) -> u32 {
    json(|module| Ok(module.episode(handle)?.path()))
}

#[unsafe(no_mangle)]
pub extern "C" fn cocarry_regions(handle: u32) -> u32 {
    json(|module| Ok(module.episode(handle)?.regions()))
}

#[unsafe(no_mangle)]
pub extern "C" fn cocarry_summary(handle: u32) -> u32 {
    json(|module| Ok(module.episode(handle)?.summary()))
}

#[unsafe(no_mangle)]
pub extern "C" fn cocarry_log(handle: u32) -> u32 {
    json(|module| module.episode(handle)?.log())
}

#[unsafe(no_mangle)]
pub extern "C" fn cocarry_digest(handle: u32) -> u32 {
    bytes(|module| Ok(module.episode(handle)?.digest()?.into_bytes()))
}

#[unsafe(no_mangle)]
pub extern "C" fn cocarry_snapshot(handle: u32) -> u32 {
    bytes(|module| module.episode(handle)?.snapshot())
}
