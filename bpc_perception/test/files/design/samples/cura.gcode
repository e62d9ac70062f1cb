;FLAVOR:Marlin
;TIME:49
;Filament used: 0.413716m
;Layer height: 1
;Generated with Cura_SteamEngine 4.10.0
;Written after lhalb/cura_g-code_converter, data/hex2.gcode; numbers are made round.
M82 ;absolute extrusion mode
G28 ;Home
G92 E0
G1 F1500 E-6.5
;LAYER_COUNT:2
;LAYER:0
M107
;MESH:hex.stl
G0 F360 X15 Y-38 Z1.3
;TYPE:WALL-OUTER
G1 F1500 E0
G1 X38 Y-15 E5
G1 X38 Y15 E10
G0 X10 Y0
;TYPE:FILL
G1 X-10 Y0 E14
;TIME_ELAPSED:20
;LAYER:1
G0 X-10 Y0 Z2.3
;TYPE:SKIN
G1 X10 Y0 E18
G1 E11.5 F1500
;TIME_ELAPSED:49
G91
G1 Z5 E-2 X-20 F9000
G90
M82 ;absolute extrusion mode
;End of Gcode
;SETTING_3 {"global_quality": "[general]\\nversion = 4\\nname = Profile\\nde
;SETTING_3 finition = custom\\n\\n[metadata]\\ntype = quality_changes\\n\\n[v
;SETTING_3 alues]\\nlayer_height = 1\\n\\n", "extruder_quality": ["[general]\\
;SETTING_3 nversion = 4\\n\\n[values]\\nline_width = 0.8\\nwall_line_width_0 =
;SETTING_3  0.7\\nskin_line_width = =line_width * 2\\n\\n"]}
