"""The VLBI Field System's files: pointing data (xtr), its fits (err) and models (mdlpo.ctl)."""
