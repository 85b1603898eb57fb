"""What the plots of reports, sweeps and accuracy share: scales and axes as SVG."""
