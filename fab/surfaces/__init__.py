"""Surfaces that designs follow: from files to clean triangle meshes, every repair a finding."""
