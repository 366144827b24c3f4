"""The site of reports: pages of scenes, what was measured for them, and the way around (`symgen.site.build`)."""
