"""The configuration of a whole run, and the doctor that looks at it before the work begins."""
