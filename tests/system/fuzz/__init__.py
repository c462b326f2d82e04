"""Readers of foreign bytes, given made-up ones: declared errors alone, at once, in little memory.

Each reader is a `FuzzTarget`. What is known to reach far into it lies in ``seeds/``, one file for
each. `tests/system/test_fuzzing.py` runs those and changes of them in each `make test`; `make fuzz`
lets Atheris look for more, guided by what each input reaches.
"""
