# SPDX-License-Identifier: Apache-2.0
# Sourced by run.sh: a Slurm of one node in a folder, beside whatever Slurm the machine has. Needs root.
#   start_slurm FOLDER      sets SLURM_CONF; stop_slurm ends what was started

start_slurm() {
    local folder="$1" host
    slurm_folder="$folder"
    host="$(hostname -s)"
    mkdir -p "$folder"/{state,spool,munge}
    # munged wants folders that nobody else can write.
    chmod 755 "$folder"
    dd if=/dev/urandom of="$folder/munge/key" bs=1024 count=1 status=none
    chmod 400 "$folder/munge/key"
    chown -R munge "$folder/munge"
    # As munge: its socket's folder must be passable for all.
    runuser -u munge -- munged --force --key-file="$folder/munge/key" --socket="$folder/munge/socket" \
        --log-file="$folder/munge/log" --pid-file="$folder/munge/pid" --seed-file="$folder/munge/seed" --num-threads=1
    cat >"$folder/slurm.conf" <<END
ClusterName=test
SlurmctldHost=$host(127.0.0.1)
SlurmUser=root
SlurmctldPort=16817
SlurmdPort=16818
AuthInfo=socket=$folder/munge/socket
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core_Memory
StateSaveLocation=$folder/state
SlurmdSpoolDir=$folder/spool
SlurmctldPidFile=$folder/slurmctld.pid
SlurmdPidFile=$folder/slurmd.pid
SlurmctldLogFile=$folder/slurmctld.log
SlurmdLogFile=$folder/slurmd.log
ReturnToService=2
KillWait=10
MinJobAge=3600
SchedulerParameters=sched_interval=2,bf_interval=2,batch_sched_delay=0
NodeName=$host NodeAddr=127.0.0.1 CPUs=2 RealMemory=6000
PartitionName=all Nodes=ALL Default=YES MaxTime=INFINITE State=UP
END
    echo 'CgroupPlugin=cgroup/v1' >"$folder/cgroup.conf"
    export SLURM_CONF="$folder/slurm.conf"
    timeout 30 slurmctld -f "$SLURM_CONF"
    timeout 30 slurmd -f "$SLURM_CONF"
    for _ in $(seq 60); do
        [ "$(timeout 10 sinfo --noheader --format=%T 2>/dev/null)" != idle ] || return 0
        sleep 0.5
    done
    tail -n 5 "$folder"/*.log >&2
    return 1
}

stop_slurm() {
    local file
    for file in slurmd.pid slurmctld.pid munge/pid; do
        [ ! -s "$slurm_folder/$file" ] || kill "$(cat "$slurm_folder/$file")" 2>/dev/null || true
    done
}
