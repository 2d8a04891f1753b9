#!/bin/sh
# A SLURM of one node from Debian's packages, to try `hydra/launcher=slurm` without a cluster.
# As root, in a container or virtual machine of Debian 12 that may be thrown away afterwards:
#
#     sh docs/slurm_one_node.sh
#
# It knows no users, no accounting and no limits on memory: it shows that jobs arrive, run, are stopped and
# queued again, not how a cluster is run.
set -eu

export DEBIAN_FRONTEND=noninteractive
apt-get update -q
apt-get install -y -q --no-install-recommends slurmctld slurmd slurm-client munge

node=$(hostname -s)
getent hosts "$node" > /dev/null || echo "127.0.0.1 $node" >> /etc/hosts
memory_mb=$(awk '/MemTotal/ { print int($2 / 1024 * 0.9) }' /proc/meminfo)

cat > /etc/slurm/slurm.conf << END
ClusterName=one
SlurmctldHost=$node
SlurmUser=root
AuthType=auth/munge
StateSaveLocation=/var/spool/slurmctld
SlurmdSpoolDir=/var/spool/slurmd
SlurmctldLogFile=/var/log/slurm/slurmctld.log
SlurmdLogFile=/var/log/slurm/slurmd.log
# Without control groups, which containers often may not use.
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU_Memory
ReturnToService=2
# Seconds from asking a cancelled job to end until it is killed.
KillWait=5
NodeName=$node CPUs=$(nproc) RealMemory=$memory_mb State=UNKNOWN
PartitionName=main Nodes=$node Default=YES MaxTime=INFINITE State=UP
END
mkdir -p /var/spool/slurmctld /var/spool/slurmd /var/log/slurm

install -d -o munge -g munge -m 755 /run/munge
runuser -u munge -- /usr/sbin/munged
slurmctld
slurmd

for _ in $(seq 60); do
    sinfo -h -o %T 2> /dev/null | grep -q idle && break
    sleep 1
done
sinfo
srun --immediate=30 true && echo "SLURM is up"
