;====================================================
; Test print
; Setup: 20G x 38mm needle with 20mL syringe
;     All extrusion units are uL
; Written after a public test print of a syringe extruder on Marlin (2021), with the comments
; "Turn Extruder UV on" and "Dwell for 1s to drip if needed".
;====================================================
G90
M83; Set relative extrusion
G28; Home
G1 Z15.0 F6000; Move up 15mm
G1 F5000 E5
; layer 1
M106 P0; Turn Extruder UV on
G1 F3600 X10 Y10 Z0.25
G1 F800 X45 E1
G10 ; firmware retraction
G0 Z2
G4 S1; Dwell for 1s to drip if needed
G0 X55
G0 Z0.25
G11
G1 X90 E1
G0 Z2
; layer 2
G0 X10 Y15
G0 Z0.5
T1 ; the second syringe
G1 X45 E2
