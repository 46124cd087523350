"""The command line: ``python -m r3gw STAGE``, one subcommand per stage of the workflow.

Commands import what they run when they run, so that ``--help`` comes at once.
"""
