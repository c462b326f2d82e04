"""Signed updates of a gateway: releases beside each other, one of which is tried."""
