# SPDX-License-Identifier: Apache-2.0
nephos --crop 0,0,1,1 info a.vdb
