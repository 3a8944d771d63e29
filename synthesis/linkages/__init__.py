"""Linkages: machines of rigid links. A new one is a folder and its name here."""
