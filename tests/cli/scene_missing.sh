# SPDX-License-Identifier: Apache-2.0
nephos render nothing.yaml -o a.exr
