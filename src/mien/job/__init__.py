"""Files in, files out: what every face of the product does around the verbs."""
