//! A Slurm of two nodes on this machine, for one test: Debian's programs, run as the user of the test, ended with the
//! value.

use std::fs;
use std::net::TcpListener;
use std::os::unix::fs::PermissionsExt;
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use crate::flb::{Folder, Run};

/// Time for anything that a cluster does.
const PATIENCE: Duration = Duration::from_secs(120);
const TICK: Duration = Duration::from_millis(100);

pub(crate) struct Cluster {
    /// Where the library is.
    pub folder: Folder,
    home: tempfile::TempDir,
    /// The nodes by name, the controller, and the service that vouches for users; in the order in which they end.
    running: Vec<(&'static str, Child)>,
}

/// The words of a command.
fn said(command: &mut Command) -> String {
    let output = command
        .output()
        .unwrap_or_else(|error| panic!("{command:?}: {error}; scripts/setup test installs it"));
    String::from_utf8_lossy(&output.stdout).trim().to_owned()
}

/// Process that looks after the step that a process is the first of.
fn keeper(pid: u32) -> Option<String> {
    let status = fs::read_to_string(format!("/proc/{pid}/status")).ok()?;
    let parent = status.lines().find_map(|line| line.strip_prefix("PPid:"))?.trim().to_owned();
    let name = fs::read_to_string(format!("/proc/{parent}/comm")).ok()?;
    (name.trim() == "slurmstepd").then_some(parent)
}

impl Cluster {
    /// Starts it, and waits until both nodes are idle.
    pub(crate) fn start(folder: Folder) -> Cluster {
        let home = tempfile::tempdir().expect("a temporary folder");
        // The service refuses sockets in folders that others cannot enter.
        fs::set_permissions(home.path(), fs::Permissions::from_mode(0o755)).expect("our own folder");
        let mut cluster = Cluster { folder, home, running: Vec::new() };
        fs::write(cluster.path("slurm.conf"), cluster.settings()).expect("a file");
        fs::write(cluster.path("cgroup.conf"), "CgroupAutomount=no\n").expect("a file");
        let key = cluster.path("key");
        fs::write(&key, [7; 128]).expect("a file");
        fs::set_permissions(&key, fs::Permissions::from_mode(0o600)).expect("our own file");
        let flag = |name: &str, file: &str| format!("--{name}={}", cluster.path(file).display());
        let flags = [
            flag("key-file", "key"),
            flag("socket", "socket"),
            flag("pid-file", "munged.pid"),
            flag("log-file", "munged.log"),
            flag("seed-file", "seed"),
        ];
        let mut munged = cluster.command("munged");
        munged.arg("--foreground").args(flags);
        cluster.spawn("munged", &mut munged);
        let socket = cluster.path("socket");
        cluster.until("munged answers", || socket.exists());
        let mut controller = cluster.command("slurmctld");
        controller.args(["-D", "-c"]);
        cluster.spawn("slurmctld", &mut controller);
        for node in ["n1", "n2"] {
            let mut daemon = cluster.command("slurmd");
            daemon.args(["-D", "-N", node]).env("FLB_TEST_NODE", node);
            cluster.spawn(node, &mut daemon);
        }
        cluster.until("two nodes are idle", || {
            said(cluster.command("sinfo").args(["-h", "-t", "idle", "-o", "%D"])) == "2"
        });
        cluster
    }

    fn settings(&self) -> String {
        let ports: Vec<TcpListener> =
            (0..3).map(|_| TcpListener::bind("127.0.0.1:0").expect("a free port")).collect();
        let ports: Vec<u16> =
            ports.iter().map(|port| port.local_addr().expect("it is bound").port()).collect();
        let host = said(Command::new("hostname").arg("-s"));
        let user = said(Command::new("id").arg("-un"));
        let home = self.home.path().display();
        let mut text = format!(
            "ClusterName=flb\nSlurmctldHost={host}(127.0.0.1)\nSlurmctldPort={}\nSlurmUser={user}\nSlurmdUser={user}\n\
             AuthType=auth/munge\nAuthInfo=socket={home}/socket\nCredType=cred/munge\nStateSaveLocation={home}/state\n\
             SlurmdSpoolDir={home}/spool-%n\nSlurmctldPidFile={home}/slurmctld.pid\nSlurmdPidFile={home}/slurmd-%n.pid\n\
             ProctrackType=proctrack/linuxproc\nTaskPlugin=task/none\nJobAcctGatherType=jobacct_gather/none\n\
             AccountingStorageType=accounting_storage/none\nJobCompType=jobcomp/none\nSchedulerType=sched/backfill\n\
             SchedulerParameters=bf_interval=2,sched_interval=2,batch_sched_delay=0,sched_min_interval=100000\n\
             SelectType=select/cons_tres\nSelectTypeParameters=CR_Core_Memory\nMpiDefault=none\nReturnToService=2\n\
             SlurmdParameters=config_overrides\nPartitionName=farm Nodes=n1,n2 Default=YES MaxTime=INFINITE State=UP\n",
            ports[0]
        );
        for (node, port) in [("n1", ports[1]), ("n2", ports[2])] {
            text += &format!(
                "NodeName={node} NodeHostname={host} NodeAddr=127.0.0.1 Port={port} CPUs=1 RealMemory=4000 State=UNKNOWN\n"
            );
        }
        for folder in ["state", "spool-n1", "spool-n2"] {
            fs::create_dir(self.path(folder)).expect("a folder");
        }
        text
    }

    /// Slurm's settings, for its commands.
    pub(crate) fn conf(&self) -> PathBuf {
        self.path("slurm.conf")
    }

    fn path(&self, name: &str) -> PathBuf {
        self.home.path().join(name)
    }

    /// One of Slurm's programs, with its settings.
    pub(crate) fn command(&self, program: &str) -> Command {
        let path = std::env::var("PATH").unwrap_or_default();
        let mut command = Command::new(program);
        command.env("SLURM_CONF", self.path("slurm.conf")).env("PATH", format!("{path}:/usr/sbin:/usr/bin"));
        command
    }

    fn spawn(&mut self, name: &'static str, command: &mut Command) {
        let log = fs::File::create(self.path(&format!("{name}.out"))).expect("a file");
        let again = log.try_clone().expect("a file");
        let child = command.stdin(Stdio::null()).stdout(log).stderr(again).spawn();
        let child = child.unwrap_or_else(|error| panic!("{name}: {error}; scripts/setup test installs it"));
        self.running.insert(0, (name, child));
    }

    /// Runs `flb` in the folder of the library.
    pub(crate) fn flb(&self, words: &[&str]) -> Run {
        let conf = self.path("slurm.conf").display().to_string();
        self.folder.flb_in(&[("SLURM_CONF", &conf)], words)
    }

    /// Waits for something.
    pub(crate) fn until(&self, what: &str, is_so: impl Fn() -> bool) {
        let begin = Instant::now();
        while !is_so() {
            assert!(begin.elapsed() < PATIENCE, "{what}: not within {PATIENCE:?}: {}", self.logs());
            thread::sleep(TICK);
        }
    }

    /// Node that runs a task of the first array, counted from 1.
    pub(crate) fn node_of_task(&self, number: usize) -> String {
        let running = said(self.command("squeue").args(["-h", "-t", "RUNNING", "-o", "%K %N"]));
        let prefix = format!("{} ", number - 1);
        let line = running.lines().find_map(|line| line.strip_prefix(&prefix));
        line.unwrap_or_else(|| panic!("task {number} does not run: {running}")).to_owned()
    }

    /// Lets jobs begin that Slurm holds back for two minutes after a requeue.
    pub(crate) fn begin_held_jobs(&self) {
        let held = said(self.command("squeue").args(["-h", "--array", "-t", "PENDING", "-o", "%i %r"]));
        for id in held.lines().filter_map(|line| line.strip_suffix(" BeginTime")) {
            said(self.command("scontrol").args(["update", &format!("JobId={id}"), "StartTime=now"]));
        }
    }

    /// Kills a node with all that runs on it, as a loss of power does, and tells the controller.
    pub(crate) fn kill(&mut self, node: &str) {
        let at = self.running.iter().position(|(name, _)| *name == node).expect("a node");
        let (_, mut child) = self.running.remove(at);
        child.kill().expect("it runs");
        child.wait().expect("it ends");
        let marks = [format!("FLB_TEST_NODE={node}\0"), format!("SLURMD_NODENAME={node}\0")];
        let home = self.home.path().display().to_string();
        let of_node = |bytes: &[u8]| {
            let text = String::from_utf8_lossy(bytes);
            text.contains(&home) && marks.iter().any(|mark| text.contains(mark.as_str()))
        };
        // Who looks after a step writes over its own environment, and must not live to tell the controller of its end.
        let (mut first, mut then) = (Vec::new(), Vec::new());
        for entry in fs::read_dir("/proc").expect("Linux").flatten() {
            let Some(pid) = entry.file_name().to_str().and_then(|name| name.parse::<u32>().ok()) else {
                continue;
            };
            if fs::read(entry.path().join("environ")).is_ok_and(|bytes| of_node(&bytes)) {
                then.push(pid.to_string());
                first.extend(keeper(pid));
            }
        }
        assert!(!first.is_empty(), "{node} runs a step");
        said(Command::new("kill").arg("-9").args(first).args(then));
        let down = [format!("NodeName={node}"), "State=DOWN".to_owned(), "Reason=killed".to_owned()];
        said(self.command("scontrol").arg("update").args(down));
    }

    /// The end of what each program said.
    fn logs(&self) -> String {
        let log = |(name, _): &(&str, Child)| {
            let text = fs::read_to_string(self.path(&format!("{name}.out"))).unwrap_or_default();
            let lines: Vec<&str> = text.lines().rev().take(8).collect();
            format!("\n{name}:\n{}", lines.into_iter().rev().collect::<Vec<_>>().join("\n"))
        };
        let queue = said(self.command("squeue").arg("-h"));
        self.running.iter().map(log).collect::<String>() + "\n" + &queue
    }
}

impl Drop for Cluster {
    fn drop(&mut self) {
        let _ = self.command("scancel").args(["--quiet", "--state=RUNNING"]).output();
        for (_, child) in &mut self.running {
            let _ = child.kill();
            let _ = child.wait();
        }
    }
}
