"""A shard of a folder of robot programs through `lostmotion rewrite`."""

from snakemake.shell import shell

extra = snakemake.params.get("extra", "")
log = snakemake.log_fmt_shell(stdout=True, stderr=True)

shell(
    "RAYON_NUM_THREADS={snakemake.threads} lostmotion rewrite --robot {snakemake.input.robot:q} "
    "--compensator {snakemake.input.compensator:q} {snakemake.params.programs:q} --manifest {snakemake.input.manifest:q} "
    "--shard {snakemake.params.shard} --output-dir {snakemake.params.results:q} --summary {snakemake.output[0]:q} "
    "--fail-on none {extra} {log}"
)
