"""From datagrams to pictures: scene, renderer, windows, meter and the receiving loop."""
