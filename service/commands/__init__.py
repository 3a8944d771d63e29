"""The commands of `camwright`, one a file; `requests.py` answers by a service or here."""
