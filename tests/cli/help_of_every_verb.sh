# SPDX-License-Identifier: Apache-2.0
for verb in bake info sky probe compare schema help; do nephos $verb -h; done
