"""Compiles SPIR-V for an AMD GPU by Mesa's driver: `python -P _amd_worker.py FOLDER`, its own process.

The environment says for which GPU; the driver then needs none. job.json lists per shader the kinds of its
bindings, "buffer" or "texture"; what the driver says of k.spv goes to statistics.json, which also has the
driver's version. It does not import gonio: the driver brings an LLVM that must not meet Dr.Jit's.
"""

import json
import sys
from pathlib import Path
from typing import Any

import vulkan as vk

KINDS = {
    "buffer": vk.VK_DESCRIPTOR_TYPE_STORAGE_BUFFER,
    "texture": vk.VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER,
}
EXTENSION = "VK_KHR_pipeline_executable_properties"


def main(folder: Path) -> None:
    """Compile all shaders of the folder."""
    job = json.loads((folder / "job.json").read_text(encoding="utf-8"))
    application = vk.VkApplicationInfo(apiVersion=vk.VK_MAKE_VERSION(1, 2, 0))
    instance = vk.vkCreateInstance(
        vk.VkInstanceCreateInfo(pApplicationInfo=application), pAllocator=None
    )
    physical = vk.vkEnumeratePhysicalDevices(instance)[0]
    wanted = vk.VkPhysicalDevicePipelineExecutablePropertiesFeaturesKHR(
        pipelineExecutableInfo=vk.VK_TRUE
    )
    queue = vk.VkDeviceQueueCreateInfo(queueFamilyIndex=0, queueCount=1, pQueuePriorities=[1.0])
    device = vk.vkCreateDevice(
        physical,
        vk.VkDeviceCreateInfo(
            pNext=wanted, pQueueCreateInfos=[queue], ppEnabledExtensionNames=[EXTENSION]
        ),
        None,
    )
    version = int(vk.vkGetPhysicalDeviceProperties(physical).driverVersion)
    found = {
        "driver": f"{version >> 22}.{version >> 12 & 0x3FF}.{version & 0xFFF}",
        "shaders": [
            statistics(device, (folder / f"{k}.spv").read_bytes(), kinds)
            for k, kinds in enumerate(job["bindings"])
        ],
    }
    (folder / "statistics.json").write_text(json.dumps(found), encoding="utf-8")


def statistics(device: Any, words: bytes, kinds: list[str]) -> dict[str, int]:
    """What the driver says of the machine code of one compute shader, by its own names."""
    module = vk.vkCreateShaderModule(
        device, vk.VkShaderModuleCreateInfo(codeSize=len(words), pCode=words), None
    )
    bindings = [
        vk.VkDescriptorSetLayoutBinding(
            binding=k,
            descriptorType=KINDS[kind],
            descriptorCount=1,
            stageFlags=vk.VK_SHADER_STAGE_COMPUTE_BIT,
        )
        for k, kind in enumerate(kinds)
    ]
    sets = vk.vkCreateDescriptorSetLayout(
        device, vk.VkDescriptorSetLayoutCreateInfo(pBindings=bindings), None
    )
    layout = vk.vkCreatePipelineLayout(
        device, vk.VkPipelineLayoutCreateInfo(pSetLayouts=[sets]), None
    )
    stage = vk.VkPipelineShaderStageCreateInfo(
        stage=vk.VK_SHADER_STAGE_COMPUTE_BIT, module=module, pName="main"
    )
    info = vk.VkComputePipelineCreateInfo(
        flags=vk.VK_PIPELINE_CREATE_CAPTURE_STATISTICS_BIT_KHR, stage=stage, layout=layout
    )
    pipeline = vk.vkCreateComputePipelines(device, None, 1, [info], None)[0]
    ask = vk.vkGetDeviceProcAddr(device, "vkGetPipelineExecutableStatisticsKHR")
    asked = vk.VkPipelineExecutableInfoKHR(pipeline=pipeline, executableIndex=0)
    return {found.name: int(found.value.u64) for found in ask(device, asked)}


if __name__ == "__main__":
    main(Path(sys.argv[1]))
