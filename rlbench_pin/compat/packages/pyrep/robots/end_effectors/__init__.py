"""Hands. The catalogue has one, the Panda's; the names of others say so when they are used."""
