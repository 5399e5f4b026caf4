"""Registers of a core behind a bus: SystemRDL becomes the gateware's map, and what drivers are written from."""
