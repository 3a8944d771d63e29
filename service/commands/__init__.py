"""The commands of `camwright`: a question in a file in, lines, tables and files out.

`terminal.answer` answers a question by a service or here, with the same tasks; `tables` has what is
printed. The docstring of a command is the text of its `--help`. Begin with `questions.py`.
"""
