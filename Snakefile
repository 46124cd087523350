# Lets `snakemake` find the workflow from the repository's root; all of it is in workflow/Snakefile.
include: "workflow/Snakefile"


# A file that includes another does not take over what that makes by default.
rule default:
    default_target: True
    input:
        rules.all.input,
