"""What an INDI driver offers, as the signals and commands of a described device. Pure."""
