"""From YAML files and the command line to checked components."""
