//! Choice probabilities and expected costs of typical and of many options, against a plain grid over the two
//! parameters.

mod rows;

use cocarry::math;
use std::hint::black_box;
use std::time::Duration;

use cocarry::preference::{Belief, ChoiceDistribution, Posterior, Predictor, Prospect, Ways, human_choice};
use criterion::{BenchmarkId, Criterion};
use rows::{Against, Bench, Declared};

const RISK_WEIGHT: f64 = 10.0;

/// Points per parameter from which on the error of the grid for the options below stays under 1e-6: of the
/// sizes tried (1500 to 9000 by 500, then 10000, 12000 and 16000) 5500 is the last to miss it, by 1.2e-6.
const GRID: usize = 6000;

const ROWS: &[Declared] = &[
    Declared {
        name: "P_o of 4 options",
        unit: "us",
        cases: &["predict/environment_4"],
        against: &[Against::Peer("a plain grid of 6000 x 6000 midpoints", &["grid/environment_4/6000"])],
    },
    Declared { name: "nodes in gamma for it", unit: "", cases: &["nodes/4"], against: &[] },
    Declared {
        name: "that grid's distance from P_o",
        unit: "",
        cases: &["grid/distance"],
        against: &[Against::Budget(1e-6)],
    },
    Declared {
        name: "P_o of 64 options on a trade-off",
        unit: "us",
        cases: &["predict/trade_off/64"],
        against: &[],
    },
    Declared {
        name: "a node of it, per n log2 n for n options",
        unit: "ns",
        cases: &["node/64"],
        against: &[Against::Peer("4 options", &["node/4"])],
    },
    Declared {
        name: "J~_o of 4 options",
        unit: "us",
        cases: &["expected_costs/environment_4"],
        against: &[Against::Peer("P_o of these", &["predict/environment_4"])],
    },
    Declared {
        name: "a tick of a robot that learned from 100 sightings",
        unit: "us",
        cases: &["learn/tick/a human of the model", "learn/tick/chance"],
        against: &[Against::Budget(50.0)],
    },
];

/// Near Environment 4 at its start: lengths in metres, risks from the widths of the openings (0.5 m robot),
/// so that all four can win.
fn environment_4() -> [Prospect; 4] {
    [(18.0658, 1.0966), (28.5424, 2.4739), (13.3412, 0.7253), (18.0649, 1.0965)]
        .map(|(length, width)| Prospect::new(length, 0.5 / width))
}

/// Options along a trade-off of length against risk, so that none is dominated and many can win: the hard
/// case.
fn trade_off(options: usize) -> Vec<Prospect> {
    let at = |k: usize| (k as f64 + 0.5) / options as f64;
    (0..options).map(|k| Prospect::new(10.0 + 25.0 * at(k), 0.95 - 0.9 * at(k))).collect()
}

/// The plain way: the midpoints of `points` by `points` cells, powers and risks computed once per column and
/// row.
fn grid(prospects: &[Prospect], points: usize) -> Vec<f64> {
    let options = prospects.len();
    let middle =
        |lower: f64, upper: f64, k: usize| lower + (upper - lower) * (k as f64 + 0.5) / points as f64;
    let mut lengths = Vec::with_capacity(points * options);
    for k in 0..points {
        let alpha = middle(0.55, 0.95, k);
        lengths.extend(prospects.iter().map(|prospect| math::pow(prospect.length, alpha)));
    }
    let mut wins = vec![0u64; options];
    let mut risks = vec![0.0; options];
    for row in 0..points {
        let gamma = middle(0.5, 1.1, row);
        for (risk, prospect) in risks.iter_mut().zip(prospects) {
            *risk = RISK_WEIGHT * math::exp(-math::pow(-math::ln(prospect.risk), gamma));
        }
        for column in lengths.chunks_exact(options) {
            let (mut best, mut lowest) = (0, f64::INFINITY);
            for (option, (length, risk)) in column.iter().zip(&risks).enumerate() {
                if length + risk < lowest {
                    (best, lowest) = (option, length + risk);
                }
            }
            wins[best] += 1;
        }
    }
    wins.iter().map(|&count| count as f64 / (points * points) as f64).collect()
}

fn predictor() -> Predictor {
    Predictor::new(Belief::default(), RISK_WEIGHT).expect("valid parameters")
}

fn probabilities(criterion: &mut Criterion, bench: &mut Bench) {
    let (mut predictor, mut choice) = (predictor(), ChoiceDistribution::default());
    let options = environment_4();
    criterion.bench_function("predict/environment_4", |b| {
        b.iter(|| predictor.predict(black_box(&options), &mut choice))
    });
    let mut slow = criterion.benchmark_group("grid");
    slow.sample_size(10).warm_up_time(Duration::from_millis(100)).measurement_time(Duration::from_secs(1));
    slow.bench_function(BenchmarkId::new("environment_4", GRID), |b| {
        b.iter(|| grid(black_box(&options), GRID))
    });
    slow.finish();
    if bench.time("predict/environment_4").is_some() {
        predictor.predict(&options, &mut choice);
        bench.give("nodes/4", predictor.nodes_evaluated() as f64);
        let found = grid(&options, GRID);
        let distances = found.iter().zip(choice.probabilities()).map(|(g, p)| (g - p).abs());
        bench.give("grid/distance", distances.fold(0.0, f64::max));
    }
    let mut many = criterion.benchmark_group("predict/trade_off");
    for count in [4, 8, 16, 32, 64] {
        let options = trade_off(count);
        many.bench_function(BenchmarkId::from_parameter(count), |b| {
            b.iter(|| predictor.predict(black_box(&options), &mut choice));
        });
    }
    many.finish();
    for count in [4, 64] {
        if let Some(time) = bench.time(&format!("predict/trade_off/{count}")) {
            predictor.predict(&trade_off(count), &mut choice);
            let (nodes, n) = (predictor.nodes_evaluated() as f64, count as f64);
            let per_node = time * 1e3 / nodes / (n * math::ln(n) / std::f64::consts::LN_2);
            bench.give(&format!("node/{count}"), per_node);
        }
    }
}

fn costs(criterion: &mut Criterion) {
    let (mut predictor, mut costs) = (predictor(), Vec::new());
    let options = environment_4();
    criterion.bench_function("expected_costs/environment_4", |b| {
        b.iter(|| predictor.expected_costs(black_box(&options), &mut costs));
    });
}

/// Looks at a human who walks option after option near Environment 4, each from another place.
fn sightings(count: usize, human: impl Fn(usize, &[Prospect]) -> usize) -> Vec<([Prospect; 4], [f64; 4])> {
    let sighting = |k: usize| {
        let (near, turn) = (1.0 - 0.6 * (k % 25) as f64 / 25.0, 0.2 * math::sin(k as f64));
        let options = environment_4();
        let at = |o: usize| {
            let Prospect { length, risk } = options[o];
            let along = if o.is_multiple_of(2) { turn } else { -turn };
            Prospect::new(length * near * (1.0 + along), risk * (1.0 - 0.3 * along))
        };
        let prospects: [Prospect; 4] = std::array::from_fn(at);
        let chosen = human(k, &prospects);
        (prospects, std::array::from_fn(|o| if o == chosen { 0.985 } else { 0.005 }))
    };
    (0..count).map(sighting).collect()
}

/// One tick of a robot that learns, after 100 sightings: a sighting from where P_o was asked for in the tick
/// before, then P_o and J~_o from the next place.
fn learning(criterion: &mut Criterion) {
    let human = cocarry::preference::Perception { alpha: 0.747, gamma: 0.765 };
    let of_model = |_: usize, prospects: &[Prospect]| human_choice(prospects, RISK_WEIGHT, human, None);
    let by_chance = |k: usize, _: &[Prospect]| (k * k + k / 3) % 4;
    let mut group = criterion.benchmark_group("learn");
    for (name, sightings) in
        [("a human of the model", sightings(102, of_model)), ("chance", sightings(102, by_chance))]
    {
        let mut posterior = Posterior::new(Belief::default(), RISK_WEIGHT).expect("valid parameters");
        let (mut choice, mut costs) = (ChoiceDistribution::default(), Vec::new());
        let (before, last) = sightings.split_at(100);
        for (prospects, likelihoods) in before {
            posterior.mix_with_prior(0.001).expect("a rate");
            posterior.observe(prospects, &Ways::default(), likelihoods).expect("possible");
        }
        let learned = posterior.learned();
        let mut k = 0;
        group.bench_function(BenchmarkId::new("tick", name), |b| {
            b.iter(|| {
                let (seen, asked) = (&last[k % 2], &last[(k + 1) % 2]);
                k += 1;
                posterior.mix_with_prior(0.001).expect("a rate");
                posterior.observe(black_box(&seen.0), &Ways::default(), &seen.1).expect("possible");
                posterior.predict_from(&asked.0, &Ways::default(), &mut choice);
                posterior.expected_costs(&asked.0, &mut costs);
                posterior.restore(&learned)
            });
        });
        group.bench_function(BenchmarkId::new("restore", name), |b| b.iter(|| posterior.restore(&learned)));
        println!("{name}: {} steps", posterior.size());
    }
    group.finish();
}

fn main() {
    rows::run("preference", ROWS, |criterion, bench| {
        probabilities(criterion, bench);
        costs(criterion);
        learning(criterion);
    });
}
