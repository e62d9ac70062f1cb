"""How Fast DDS carries messages: profiles, and shared memory left by killed processes."""
