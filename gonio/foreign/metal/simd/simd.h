// Part of metal_stdlib here.
#pragma once
