//! `cocarry study` as a researcher uses it. What a participant does is tested in a browser:
//! `viewer/test/people.mjs`.

use crate::support::is_built_of;

/// The page that the program has within is built from `viewer/people`.
#[test]
fn the_page_of_studies_that_ships_is_built_from_the_sources_that_ship() {
    let others =
        ["build.mjs", "package-lock.json", "package.json", "../page/carry.js", "../../crates/web/cocarry.js"];
    assert!(
        is_built_of("assets/people/index.html", "viewer/people", &others),
        "build it anew: cd viewer && npm ci && cd people && npm ci && node build.mjs"
    );
}

#[cfg(not(feature = "people"))]
#[test]
fn a_program_without_the_feature_says_how_to_get_it() {
    let output = crate::support::cocarry(&["study", "check", "study.toml"]);
    assert_eq!(output.status.code(), Some(2));
    let said = crate::support::stderr(&output);
    assert!(said.contains("cargo install --path crates/program --features people"), "{said}");
}

#[cfg(feature = "people")]
mod with_people {
    use crate::support::{COLLECTED, cocarry, done, json, new_study, stderr};
    use std::io::{BufRead, BufReader, Read, Write};
    use std::net::TcpStream;
    use std::path::Path;
    use std::process::{Command, Stdio};

    fn text(path: &Path) -> &str {
        path.to_str().unwrap()
    }

    #[test]
    fn people_a_study_is_checked_and_a_fault_is_told_with_its_place() {
        let (folder, file) = new_study();
        let said = done(&["study", "check", text(folder.path())]);
        assert!(said.contains("percentages: 2 maps\nswitch: 8 walks\n"), "{said}");
        let written = std::fs::read_to_string(&file).unwrap();
        std::fs::write(&file, written.replace("participants = 20", "participants = \"many\"")).unwrap();
        let output = cocarry(&["study", "check", text(&file)]);
        assert_eq!(output.status.code(), Some(2));
        let said = stderr(&output);
        assert!(said.contains("study.toml") && said.contains("participants"), "{said}");
        // nothing is replaced
        let output = cocarry(&["study", "new", text(folder.path())]);
        assert_eq!(output.status.code(), Some(2));
    }

    #[test]
    fn people_simulated_answers_go_into_fit_and_infer_and_back_to_their_truth() {
        let (folder, file) = new_study();
        let (file, to, truth) = (text(&file), folder.path().join("answers"), folder.path().join("truth.csv"));
        let simulate =
            ["study", "simulate", file, "--participants", "12", "--seed", "3", "--truth", text(&truth)];
        done(&simulate);
        let said = done(&["study", "collect", file, "--simulated", "-o", text(&to)]);
        assert!(said.ends_with("12 participants\n"), "{said}");
        let (answers, switches) = (to.join("answers.csv"), to.join("switches.csv"));
        // 12 people, 2 worlds, 4 options
        for table in [&answers, &switches] {
            assert_eq!(std::fs::read_to_string(table).unwrap().lines().count(), 1 + 12 * 2 * 4);
        }
        let fit = json(&["fit", "risk-weight", text(&answers), "--resamples", "40", "--json"]);
        assert_eq!(fit["participants"], 12);
        let fit = json(&["fit", "eta", text(&switches), "--json"]);
        let mut truths = std::collections::BTreeMap::new();
        for row in csv::Reader::from_path(&truth).unwrap().deserialize::<(String, f64, f64, f64)>() {
            let (participant, _, _, eta) = row.unwrap();
            truths.insert(participant, eta);
        }
        // every episode bounds the eta from which it came
        let mut bounded = 0;
        for episode in fit["episodes"].as_array().unwrap() {
            let eta = truths[episode["participant"].as_str().unwrap()];
            for ends in episode["eta"].as_array().unwrap() {
                let high = ends[1].as_f64().unwrap_or(f64::INFINITY);
                assert!(ends[0].as_f64().unwrap() <= eta + 1e-3 && eta <= high + 1e-3, "{eta}: {episode}");
                bounded += 1;
            }
        }
        assert_eq!(bounded, 12 * 2 * 4);
        let inferred = json(&["infer", text(&answers), text(&switches), "--draws", "100", "--json"]);
        assert_eq!(inferred["people"].as_array().map(Vec::len), Some(12), "{inferred}");
        // the same again is the same
        let again = folder.path().join("again");
        done(&[&simulate[..], &["--overwrite"]].concat());
        done(&["study", "collect", file, "--simulated", "-o", text(&again)]);
        for name in COLLECTED {
            assert_eq!(
                std::fs::read(to.join(name)).unwrap(),
                std::fs::read(again.join(name)).unwrap(),
                "{name}"
            );
        }
        // every column is explained
        let dictionary = std::fs::read_to_string(to.join("dictionary.csv")).unwrap();
        for name in ["answers.csv", "switches.csv", "participants.csv", "responses.csv"] {
            let table = std::fs::read_to_string(to.join(name)).unwrap();
            for column in table.lines().next().unwrap().split(',') {
                assert!(dictionary.contains(&format!("{name},{column},")), "{name}: {column}");
            }
        }
    }

    #[test]
    fn people_answers_of_your_own_world_go_with_its_file() {
        let (folder, file) = new_study();
        std::fs::copy(
            crate::support::repository("worlds/environment-1.toml"),
            folder.path().join("mine.toml"),
        )
        .unwrap();
        let written = std::fs::read_to_string(&file).unwrap();
        std::fs::write(&file, written.replace("\"environment-4\"]", "\"mine.toml\"]")).unwrap();
        let (file, to) = (text(&file), folder.path().join("answers"));
        done(&["study", "simulate", file, "--participants", "2"]);
        done(&["study", "collect", file, "--simulated", "-o", text(&to)]);
        assert!(std::fs::read_to_string(to.join("answers.csv")).unwrap().contains(",worlds/mine.toml,1,"));
        let fit = json(&["fit", "risk-weight", text(&to.join("answers.csv")), "--resamples", "40", "--json"]);
        assert_eq!(fit["participants"], 2);
    }

    #[test]
    fn people_a_page_without_our_server_is_plain_files_that_send_to_their_sink_alone() {
        let (folder, file) = new_study();
        let written = std::fs::read_to_string(&file).unwrap();
        std::fs::write(&file, written.replace("# code = ", "code = ")).unwrap();
        for (sink, connects, has_jatos) in [
            ("download", "connect-src 'self';", false),
            ("jatos", "connect-src 'self';", true),
            ("datapipe=abc123", "connect-src 'self' https://pipe.jspsych.org;", false),
        ] {
            let to = folder.path().join(sink);
            let build = ["study", "build", text(&file), "--sink", sink, "-o", text(&to)];
            done(&build);
            let study = std::fs::read_to_string(to.join("study.json")).unwrap();
            let name = sink.split('=').next().unwrap();
            assert!(study.contains(&format!("\"sink\":\"{name}\"")) && !study.contains("risk"), "{study}");
            assert!(study.contains("\"code\":\"C0FFEE\""), "{study}");
            assert_eq!(study.contains("\"experiment\":\"abc123\""), sink.starts_with("datapipe"));
            let page = std::fs::read_to_string(to.join("index.html")).unwrap();
            assert!(page.contains("default-src 'none'; script-src 'self' 'wasm-unsafe-eval';"), "{page}");
            assert!(page.contains(connects), "{page}");
            assert_eq!(page.contains("<script src=\"jatos.js\">"), has_jatos);
            for name in ["study.js", "study.css", "NOTICE.txt", "maps/1.svg", "maps/2.svg", "maps/3.svg"] {
                assert!(to.join(name).is_file(), "{name}");
            }
            let output = cocarry(&build);
            assert_eq!(output.status.code(), Some(2), "files are not replaced unasked");
        }
        for wrong in ["ftp", "datapipe=", "datapipe=a/b"] {
            let to = folder.path().join("wrong");
            let output = cocarry(&["study", "build", text(&file), "--sink", wrong, "-o", text(&to)]);
            assert_eq!(output.status.code(), Some(2));
            assert!(stderr(&output).contains("download, jatos, or datapipe=ID"), "{}", stderr(&output));
            assert!(!to.exists());
        }
    }

    #[test]
    fn people_walks_are_shown_again_grouped_by_eta_and_a_scale_of_fluency_has_its_means() {
        let (folder, file) = new_study();
        let written = std::fs::read_to_string(&file).unwrap();
        let edited = written
            .replace("# trials = 2 ", "trials = 2 ")
            .replace("kind = \"nasa-tlx\"", "kind = \"fluency\"\npoints = 5");
        std::fs::write(&file, edited).unwrap();
        let (file, to, truth) = (text(&file), folder.path().join("answers"), folder.path().join("truth.csv"));
        assert!(done(&["study", "check", file]).contains("switch: 16 walks\n"));
        done(&["study", "simulate", file, "--participants", "6", "--truth", text(&truth)]);
        done(&["study", "collect", file, "--simulated", "-o", text(&to)]);
        // both showings are read: 6 people, 2 worlds, 4 options
        let fit = json(&["fit", "eta", text(&to.join("switches.csv")), "--json"]);
        assert_eq!(fit["episodes"].as_array().unwrap().len(), 6 * 2 * 4 * 2);
        let read = |name: &str| {
            let rows = csv::Reader::from_path(to.join(name)).unwrap().into_deserialize();
            rows.collect::<Result<Vec<std::collections::BTreeMap<String, String>>, _>>().unwrap()
        };
        let mut trials = std::collections::BTreeMap::new();
        read("switches.csv").iter().for_each(|row| *trials.entry(row["trial"].clone()).or_insert(0) += 1);
        assert_eq!(trials.into_iter().collect::<Vec<_>>(), [("1".to_owned(), 48), ("2".to_owned(), 48)]);
        // who stops a walk belongs to the group nearest to the eta that was drawn, up to the width of a step
        let truths: std::collections::BTreeMap<String, f64> = csv::Reader::from_path(&truth)
            .unwrap()
            .deserialize::<(String, f64, f64, f64)>()
            .map(|row| row.map(|(participant, _, _, eta)| (participant, eta)).unwrap())
            .collect();
        for row in read("participants.csv") {
            let eta = truths[&row["participant"]];
            let Ok(group) = row["eta_group"].parse::<f64>() else { continue };
            let nearest = [5.0, 10.5, 15.0].into_iter().find(|other| {
                let ratio = |group: f64| (group / eta).max(eta / group);
                ratio(*other) * 1.1 < ratio(group)
            });
            assert_eq!(nearest, None, "eta {eta} in the group of {group}");
        }
        // the middle of five points is the mean of every subscale
        let responses = std::fs::read_to_string(to.join("responses.csv")).unwrap();
        assert_eq!(responses.matches(",workload,mean: human-robot fluency,3.000,").count(), 6);
        assert_eq!(responses.lines().filter(|line| line.contains(",workload,")).count(), 6 * (23 + 7));
        let dictionary = std::fs::read_to_string(to.join("dictionary.csv")).unwrap();
        let reversed = dictionary.lines().filter(|line| line.contains("reversed part of")).count();
        assert_eq!(reversed, 4);
        assert!(dictionary.contains("1 to 5"), "{dictionary}");
    }

    #[test]
    fn people_nobody_has_answered_and_nobody_is_known() {
        let (folder, file) = new_study();
        for words in
            [&["forget", text(&file), "anna"][..], &["collect", text(&file), "-o", text(folder.path())]]
        {
            let output = cocarry(&[&["study"], words].concat());
            assert_eq!(output.status.code(), Some(2));
            assert!(stderr(&output).contains("study.sqlite: nobody has answered yet"), "{}", stderr(&output));
        }
    }

    #[cfg(unix)]
    #[test]
    fn people_a_study_is_served_until_ctrl_c() {
        let (folder, file) = new_study();
        let mut child = Command::new(env!("CARGO_BIN_EXE_cocarry"))
            .args(["study", "serve", text(&file), "--port", "0"])
            .stdout(Stdio::piped())
            .spawn()
            .expect("the program starts");
        let mut line = String::new();
        BufReader::new(child.stdout.take().unwrap()).read_line(&mut line).unwrap();
        let host =
            line.trim().strip_prefix("the study is at http://").and_then(|rest| rest.strip_suffix('/'));
        let host = host.unwrap_or_else(|| panic!("{line:?}"));
        let mut stream = TcpStream::connect(host).unwrap();
        write!(stream, "GET / HTTP/1.1\r\nHost: {host}\r\nConnection: close\r\n\r\n").unwrap();
        let mut answer = String::new();
        stream.read_to_string(&mut answer).unwrap();
        assert!(answer.starts_with("HTTP/1.1 200") && answer.contains("study.js"), "{answer}");
        assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
        assert_eq!(child.wait().unwrap().code(), Some(0));
        assert!(folder.path().join("study.sqlite").is_file());
        assert!(done(&["study", "check", text(&file)]).contains("sound; 0 began, 0 finished"));
    }
}
