//! `stress` in several processes.

use super::Folder;

/// A pipeline with a tier, so that it is two targets.
const PIPELINE: &str = r#"Pipeline(
    inputs: { "scene": Color },
    nodes: { "soft": Gaussian(source: "scene", sigma: 4.0) },
    outputs: { "soft": "soft" },
    tiers: { "low": { "soft.sigma": 2.0 } },
)"#;

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn processes_report_what_one_process_does() {
    let folder = Folder::new("stress-jobs");
    std::fs::create_dir(folder.file("in")).expect("a folder");
    folder.with("in/soft.ron", PIPELINE.as_bytes());
    // Without sanitizing there are failures, too. The first targets take longer than the last.
    let run = |jobs: u32| {
        let kinds = "--kind Gaussian --kind AutoExposure --kind Vignette --kind Exposure";
        let line = format!(
            "-C in stress soft.ron {kinds} --unsanitized --quick --defaults --allow . --jobs {jobs} --json r.json"
        );
        let outcome = folder.run(&line);
        (outcome, std::fs::read_to_string(folder.file("in/r.json")).expect("the results"))
    };
    let ((one, results), (three, same)) = (run(1), run(3));
    assert_eq!(one.status, Some(1), "{}", one.err);
    assert_eq!((three.status, &three.out), (one.status, &one.out), "{}", three.err);
    assert_eq!(same, results);
    for title in
        ["\nsoft.ron (low)", "\nGaussian", "afterimage stress soft.ron --tier low --allow . --unsanitized --defaults"]
    {
        assert!(one.out.contains(title), "{title}: {}", one.out);
    }
    folder.run("stress --kind Vignette --jobs 0").fails_saying(1, &["--jobs <COUNT>"]);
}

/// A process of a run that is killed has nobody to report to.
#[test]
#[cfg(target_os = "linux")]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_run_that_is_killed_leaves_no_process() {
    let folder = Folder::new("stress-killed");
    let mark = format!("AFTERIMAGE_TEST_MARK={}", std::process::id());
    // Processes inherit the variable.
    let marked = || {
        let processes = std::fs::read_dir("/proc").expect("the system has a list").flatten();
        let environments = processes.filter_map(|process| std::fs::read(process.path().join("environ")).ok());
        environments.filter(|all| all.split(|byte| *byte == 0).any(|one| one == mark.as_bytes())).count()
    };
    let wait_for = |what: &str, is_so: &dyn Fn(usize) -> bool| {
        let start = std::time::Instant::now();
        while !is_so(marked()) {
            assert!(start.elapsed().as_secs() < 60, "{what}: {} processes", marked());
            std::thread::sleep(std::time::Duration::from_millis(20));
        }
    };
    let (name, value) = mark.split_once('=').expect("a variable and its value");
    let mut command = folder.command("stress --kinds --jobs 2");
    let quiet = command.env(name, value).stdout(std::process::Stdio::null()).stderr(std::process::Stdio::null());
    let mut run = quiet.spawn().expect("the program starts");
    wait_for("it starts two", &|count| count >= 3);
    run.kill().and_then(|()| run.wait()).expect("it is killed");
    wait_for("they end", &|count| count == 0);
}
