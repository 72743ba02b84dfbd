# A Slurm for tests, to be sourced: a controller and two nodes, n1 and n2, on this computer, without systemd or
# munge. Needs `cocarry`, the program; root; and Debian's slurmctld, slurmd and slurm-client, which it installs
# where apt-get can. It ends the test as skipped elsewhere. It sets `work`, a new folder, and `checks`, a count,
# and has functions that wait, compare and kill a node.

skip() { echo "skipped: studies on Slurm; $1"; exit 0; }
[ "$(id -u)" = 0 ] || skip "the test starts Slurm's daemons as root"
if ! command -v slurmctld slurmd sbatch > /dev/null; then
  command -v apt-get > /dev/null || skip "install slurmctld, slurmd and slurm-client"
  # policy-rc.d would keep services from starting; without systemd none does
  { apt-get update && DEBIAN_FRONTEND=noninteractive apt-get -o DPkg::Lock::Timeout=300 install -y --no-install-recommends slurmctld slurmd slurm-client; } \
    > /dev/null 2>&1 || skip "slurmctld, slurmd and slurm-client could not be installed"
fi

work=$(mktemp -d)
export SLURM_CONF=$work/slurm.conf
host=$(hostname -s)
port=$((20000 + RANDOM % 20000))
checks=0

finish() {
  code=$?
  scancel --state=PENDING,RUNNING --user=root 2> /dev/null || true
  pkill -9 -f "slurm(d|ctld) .*$work" || true
  pkill -9 -f "slurmstepd: \[" || true
  umount "$work/small" 2> /dev/null || true
  if [ $code != 0 ]; then
    echo "failed after $checks checks; the controller's log ends with:"
    tail -n 20 "$work/ctld.log" 2> /dev/null || true
  fi
  rm -rf "$work"
  exit $code
}
trap finish EXIT

cat > "$SLURM_CONF" << CONF
ClusterName=test
SlurmctldHost=$host(127.0.0.1)
SlurmUser=root
SlurmdUser=root
AuthType=auth/none
CredType=cred/none
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SwitchType=switch/none
MpiDefault=none
SlurmctldPort=$port
SlurmctldPidFile=$work/ctld.pid
SlurmdPidFile=$work/%n.pid
SlurmdSpoolDir=$work/spool-%n
StateSaveLocation=$work/state
SlurmctldLogFile=$work/ctld.log
SlurmdLogFile=$work/%n.log
ReturnToService=2
SlurmdTimeout=5
KillWait=2
MinJobAge=300
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
AccountingStorageType=accounting_storage/none
# task 4 is the largest
MaxArraySize=5
SchedulerParameters=sched_interval=1,batch_sched_delay=0
NodeName=n1 NodeHostname=$host NodeAddr=127.0.0.1 Port=$((port + 1)) CPUs=1 State=UNKNOWN
NodeName=n2 NodeHostname=$host NodeAddr=127.0.0.1 Port=$((port + 2)) CPUs=1 State=UNKNOWN
PartitionName=main Nodes=ALL Default=YES MaxTime=INFINITE State=UP
CONF
mkdir -p "$work"/{state,spool-n1,spool-n2,small}
slurmctld -c -f "$SLURM_CONF"
start_node() { slurmd -N "$1" -f "$SLURM_CONF"; }
start_node n1
start_node n2

# waits up to N seconds for a condition
wait_for() {
  local seconds=$1 what=$2
  shift 2
  for _ in $(seq $((seconds * 5))); do
    if "$@" > /dev/null 2>&1; then return; fi
    sleep 0.2
  done
  echo "not so after $seconds s: $what"
  squeue || true
  return 1
}
says() { # a command's output and its exit code: says CODE TEXT COMMAND...
  local expected=$1 text=$2 said code=0
  shift 2
  said=$("$@" 2>&1) || code=$?
  if [ "$code" != "$expected" ] || ! grep -qF -- "$text" <<< "$said"; then
    printf 'expected exit code %s and `%s`, found %s:\n%s\n' "$expected" "$text" "$code" "$said"
    return 1
  fi
  checks=$((checks + 1))
}
same() { cmp "$1" "$2" && checks=$((checks + 1)); }
idle() { [ "$(sinfo -h -t idle -o %D)" = 2 ]; }
queue_is_empty() { [ -z "$(squeue -h)" ]; }
shards() { "$cocarry" cluster status "$1" | head -n 1; }
done_of() { shards "$1" | grep -q ": $2 of "; }
node_runs() { squeue -h -t RUNNING -w "$1" -o %i | grep -q .; }
begun() { ls "$1".job/shards/*.partial; }

# a node with everything on it dies: kill_node NODE RESULTS
kill_node() {
  pkill -9 -f "slurmd -N $1 .*$work" || true
  for job in $(squeue -h -t RUNNING -w "$1" -o %A); do pkill -9 -f "slurmstepd: \[$job" || true; done
  for child in $(pgrep -f "cluster shard $work/$2" || true); do
    if grep -qz "SLURMD_NODENAME=$1" "/proc/$child/environ" 2> /dev/null; then kill -9 "$child"; fi
  done
}

wait_for 30 "both nodes are idle" idle
