"""The version, in one place: packaging reads it, headers and manifests print it."""

VERSION = "0.1.0"
