use cocarry::experiments::h3::*;
fn main() {
    let robot = cocarry::robot::Robot::built_in().unwrap();
    let n: usize = std::env::args().nth(1).map_or(10, |a| a.parse().unwrap());
    let mut control = cocarry::control::Settings::default();
    if let Some(c) = std::env::args().nth(2) {
        control.direction_concentration = c.parse().unwrap();
    }
    let settings = cocarry::episode::Settings::default();
    let study = Study { robot: &robot, episodes: n, seed: 0, episode: &settings, control };
    let t = std::time::Instant::now();
    let rows = study.table(&|| ()).unwrap();
    for row in &rows {
        println!(
            "{} {} {:10} {:22} {:8.1} ± {:6.1} ratio {:.3} p {:8.1e} wins {:3} parts {:7.1} {:7.1} {:6.2} err {:.4} lim {:.2} fb {} over {} lost {}",
            row.environment,
            row.setting,
            row.start,
            row.method.name(),
            row.ours_mean,
            row.ours_std,
            row.ratio,
            row.p_value.unwrap_or(f64::NAN),
            row.wins,
            row.parts[0],
            row.parts[1],
            row.parts[2],
            row.position_error_rms,
            row.constrained_share,
            row.fallback_steps,
            row.overlapping_episodes,
            row.not_arrived
        );
    }
    for start in ["elbow-up", "elbow-out"] {
        for m in PoseMethod::ALL {
            let r: Vec<f64> =
                rows.iter().filter(|r| r.start == start && r.method == m).map(|r| r.ratio).collect();
            println!(
                "{start} {:22} mean ratio {:.3} min {:.3} max {:.3}",
                m.name(),
                r.iter().sum::<f64>() / r.len() as f64,
                r.iter().copied().fold(9.0, f64::min),
                r.iter().copied().fold(0.0, f64::max)
            );
        }
    }
    println!("{:?} for {} episodes", t.elapsed(), study.units());
}
