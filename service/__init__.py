"""The web service of Camwright: validates, dispatches, reports; computes nothing."""
