"""Looking at the machine: which parts are there, and whether it is fit to run them."""
