"""HTML reports: pages from templates, the words they explain, the motion they animate."""
