"""Transmission between motor and link."""
