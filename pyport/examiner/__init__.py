"""The examiner: recordings of known truth, and others' recordings, put to the program from outside.

Whatever is drawn here has formulae of its own. Of pyport only `program` is imported, which
calls the public API.
"""
